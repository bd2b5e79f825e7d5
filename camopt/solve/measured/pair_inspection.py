"""A measured cam with two contacts of its follower: their distance, and the preload that is left.

Each contact moves by e more than the nominal motion (``measured.inspection``). Both contacts together then need

    s(θ) = e₁(θ) + e₂(θ),    for a yoke e(θ) + e(θ + π)

more than the follower has between them, at any position of it. By this amount the subtending angle of two arms, the
distance of two rollers along the motion, or the breadth of a disc in its yoke is off (``mechanisms.pairs``). With
an interference δ₀ against the stiffness k, each contact presses at rest with

    P(θ) = k·(δ₀ + s(θ))

If δ₀ + s is below 0, there is a clearance of the same size. Both contacts share a force F along the motion, so one
lets go if |F|/2 > P (``effects.preload``). F is that of the nominal motion.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.model.effects import force
from camopt.model.mechanisms.pairs import second_disc_designs
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.tolerances import tolerance_zone
from camopt.solve.measured.columns import TableReadingOptions
from camopt.solve.measured.inspection import (
    WRONG_CAM_SHARE,
    InspectedDisc,
    Inspection,
    inspect_discs,
    refine_zero_angle,
)
from camopt.solve.measured.outline import ANGLE_DIGITS
from camopt.solve.measured.profile import MeasuredProfile
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table


class Extreme(NamedTuple):
    """An extreme over the turn and its cam angle."""

    value: float
    at_deg: float


@dataclass(frozen=True)
class PairInspection(Result):
    """A measured cam with two contacts of its follower, compared with its drawing.

    Attributes
    ----------
    scene : Scene
        The drawing.
    discs : tuple of Inspection
        Each measured disc as a cam of its own, at its own best fit on the shaft, with errors of its own motion,
        which
        is reversed at the second disc. A yoke has one disc. Behind a train the errors are those of the follower.
    turned : float
        Angle by which disc 2 is ahead of disc 1, deg; 0 for a yoke.
    quantity : str
        The quantity between both contacts: ``subtending angle``, ``distance of the rollers`` along the motion, or
        ``breadth``.
    unit : str
        Its unit: deg or mm.
    drawn : float
        Its nominal value.
    allowed : float or None
        Its allowed deviation either way, if each profile uses its tolerance; None without a tolerance.
    angles : ndarray
        Cam angles, deg, in order.
    off : ndarray
        Its deviation at these angles: above 0 the discs hold the contacts further apart than drawn.
    interference : float
        The mounting interference; 0 if the scene has none.
    preload : ndarray or None
        Force of both contacts at rest, N (N·m); below 0 they do not press. None if the stiffness is unknown.
    needed : ndarray or None
        Preload that keeps both contacts at the speed of the scene, N (N·m): half of the force. None if unknown.
    reason : str
        Why the discs do not hold one follower, such as a disc of another drawing; ``off`` is nan then.

    Examples
    --------
    >>> scene = camopt.find_scene("pump-of-constant-breadth")
    >>> points = camopt.cam_points(scene, range(0, 360, 2))
    >>> profile = np.column_stack([points["profile_x_mm"], points["profile_y_mm"]])
    >>> found = camopt.inspect_pair([camopt.MeasuredProfile(1.001 * profile, "xy")], scene)
    >>> found.quantity, round(found.drawn, 3), round(found.least.value, 3), round(found.most.value, 3)
    ('breadth', 64.0, 0.064, 0.064)
    """

    scene: Scene
    discs: tuple[Inspection, ...]
    turned: float
    quantity: str
    unit: str
    drawn: float
    allowed: float | None
    angles: FloatArray
    off: FloatArray
    interference: float
    preload: FloatArray | None
    needed: FloatArray | None
    reason: str = ""

    @property
    def least(self) -> Extreme:
        """Least deviation of the contacts' distance, and its cam angle."""
        return self._smallest_value_with_cam_angle(self.off)

    @property
    def most(self) -> Extreme:
        """Largest deviation of the contacts' distance, and its cam angle."""
        place = int(np.argmax(self.off))
        return Extreme(float(self.off[place]), float(self.angles[place]))

    @property
    def variation(self) -> float:
        """Largest less least deviation over the turn."""
        return self.most.value - self.least.value

    @property
    def within(self) -> bool | None:
        """Whether the deviation is within the allowed one; None if nothing is allowed or the discs do not match."""
        return None if self.allowed is None or self.reason else bool(np.abs(self.off).max() <= self.allowed)

    @property
    def left(self) -> Extreme:
        """Least remaining interference, deg or mm; below 0 the largest clearance."""
        return self._smallest_value_with_cam_angle(self.interference + self.off)

    @property
    def spare(self) -> Extreme | None:
        """Least preload beyond the needed one, N (N·m); below 0 a contact lets go. None if it is unknown."""
        if self.preload is None or self.needed is None:
            return None
        return self._smallest_value_with_cam_angle(self.preload - self.needed)

    def _smallest_value_with_cam_angle(self, values: FloatArray) -> Extreme:
        place = int(np.argmin(values))
        return Extreme(float(values[place]), float(self.angles[place]))

    def table(self) -> Table:
        """A table of the distance of both contacts, the remaining interference and the preload."""
        if self.reason:
            return Table.from_texts(
                f"Both contacts of {self.scene.name}", [""], [], f"They are not compared: {self.reason}."
            )
        drawn = with_unit(self.drawn, self.unit)
        if self.allowed is not None:
            drawn += f" ± {with_unit(self.allowed, self.unit)}"
        rows = [[self.quantity, drawn, *self._extremes_in_words(self.off, self.unit)]]
        if self.interference:
            left = self._extremes_in_words(self.interference + self.off, self.unit)
            rows.append(["interference", with_unit(self.interference, self.unit), *left])
        if self.preload is not None:
            rows.append(["preload", "", *self._extremes_in_words(self.preload, self._force_unit)])
        heads = ["", "drawn", "least", "at, deg", "most", "at, deg"]
        rows[0][0] += ", off by"
        kinds = [Cell(head, NUMERIC if head else "") for head in heads]
        return Table.from_texts(f"Both contacts of {self.scene.name}", kinds, rows, self._note)

    def _extremes_in_words(self, values: FloatArray, unit: str) -> list[str]:
        """The least and the largest of values over the turn, each with its cam angle."""
        places = int(np.argmin(values)), int(np.argmax(values))
        return [
            text for k in places for text in (with_unit(float(values[k]), unit), number_text(float(self.angles[k])))
        ]

    @property
    def _force_unit(self) -> str:
        return "N·m" if self.unit == "deg" else "N"

    @property
    def _note(self) -> str:
        """The sentences below the table."""
        left, spare = self.left, self.spare
        sentences = [
            *self._disc_phase_in_words,
            f"The {self.quantity} varies by {with_unit(self.variation, self.unit)}",
        ]
        if self.within is not None:
            sentences.append(f"{'Within' if self.within else 'Beyond'} what the tolerance of the profile allows")
        if self.interference and self.allowed is not None and self.allowed >= self.interference:
            clearance = with_unit(self.allowed - self.interference, self.unit)
            sentences.append(f"That tolerance leaves the worst pair a clearance of {clearance}")
        if left.value > 0.0:
            sentences.append(f"At rest both contacts press, with at least {with_unit(left.value, self.unit)}")
        else:
            lost = "the preload is lost there" if self.interference else "the follower has so much play there"
            sentences.append(
                f"A clearance of {with_unit(-left.value, self.unit)} at {number_text(left.at_deg)} deg: {lost}"
            )
        if spare is not None and left.value > 0.0:
            rest = f"{with_unit(abs(spare.value), self._force_unit)} of preload are"
            lets_go = f"a contact lets go at {number_text(spare.at_deg)} deg: {rest} missing"
            sentences.append(f"At its speed {lets_go if spare.value < 0.0 else f'none lets go: {rest} spare'}")
        return "".join(f"{sentence}. " for sentence in sentences).rstrip()

    @property
    def _disc_phase_in_words(self) -> list[str]:
        """A sentence on the angle of disc 2 against disc 1; none if it is 0."""
        angle_text = abs(round(self.turned, ANGLE_DIGITS))
        if not angle_text:
            return []
        direction = "ahead of" if self.turned > 0.0 else "behind"
        tolerance = self.scene.tolerances.disc_phase
        if tolerance is None:
            allowed = "what the keyway allows"
        else:
            zone = tolerance_zone(tolerance, "disc_phase", 0.0)
            is_within = zone.lower <= self.turned <= zone.upper
            allowed = f"{'within' if is_within else 'beyond'} tolerances.disc_phase"
        return [f"Disc 2 is turned by {number_text(angle_text)} deg against disc 1, {direction} it: {allowed}"]

    def sections(self) -> Iterator[Table]:
        """The table of each disc, and that of both."""
        yield from (disc.table() for disc in self.discs)
        yield self.table()

    def values_for_json(self) -> dict[str, Any]:
        """The results of each disc, and of both."""
        return {
            "scene": self.scene.name,
            "discs": [disc.values_for_json() for disc in self.discs],
            "pair": self.records(),
        }

    def records(self) -> dict[str, Any]:
        """The numbers of the pair by name, without those of each disc; None if the discs do not match."""
        inputs = {
            "quantity": self.quantity,
            "unit": self.unit,
            "drawn": self.drawn,
            "allowed": self.allowed,
            "turned_deg": self.turned,
            "interference": self.interference,
            "reason": self.reason,
        }
        results = {
            "least": self.least._asdict(),
            "most": self.most._asdict(),
            "variation": self.variation,
            "within": self.within,
            "left": self.left._asdict(),
            "preload_least": None if self.preload is None else float(self.preload.min()),
            "spare": self.spare and self.spare._asdict(),
        }
        return inputs | (dict.fromkeys(results) if self.reason else results)


@allow_positional_options
def inspect_pair(
    profiles: Sequence[MeasuredProfile],
    scene: SceneSource,
    *,
    columns: Sequence[str | int] | None = None,
    angle_unit: str = "deg",
    lift_unit: str | None = None,
    turn: float | None = None,
    keep_outliers: bool = False,
    aligned: bool = False,
) -> PairInspection:
    """Find the error of the distance between both contacts that a measured pair, or disc in a yoke, holds.

    Points of both discs are in one frame, that of the drawing as seen from its front. The axis of the bore is at 0,
    0 and both discs share one angle 0, as measured in one clamping or from the keyway. Each disc is turned to its
    own least error, and the pair to the least error of both, unless it is aligned. So an angle between the discs is
    an error of the contacts' distance, and not of a profile.

    Parameters
    ----------
    profiles : sequence of MeasuredProfile
        Points of the first and of the second disc; for a yoke those of its one disc.
    scene : Scene, str or os.PathLike
        The drawing: a scene with fixed sizes whose follower has two contacts.
    columns : sequence of str or int, optional
        Names or numbers (from 1) of the columns of all profiles, as for ``inspect``.
    angle_unit : str, default "deg"
        "deg" or "rad".
    lift_unit : str, optional
        "mm" or "inch", of the lengths.
    turn : float, optional
        The angle of one turn of the cam in the files.
    keep_outliers : bool, default False
        Whether single points far from their neighbours count for the errors too.
    aligned : bool, default False
        Whether the angle 0 of the points is that of the scene.

    Returns
    -------
    PairInspection
        The variation of the contacts' distance, the remaining clearance or interference, and its preload.

    Raises
    ------
    BadInput
        As ``inspect``; for a follower with one contact, or another number of profiles than the cam has discs.
    Unsolved
        If the convex solver fails.
    OSError
        If a file cannot be read.

    References
    ----------
    Rothbart, Cam Design Handbook, ch. 3 (conjugate and yoke cams).

    Examples
    --------
    >>> scene = camopt.find_scene("press-feed-by-pair")
    >>> points = camopt.cam_points(scene, range(0, 360, 2))
    >>> both = [
    ...     camopt.MeasuredProfile(np.column_stack([points[f"{name}_x_mm"], points[f"{name}_y_mm"]]), "xy")
    ...     for name in ("profile", "second_profile")
    ... ]
    >>> found = camopt.inspect_pair(both, scene)
    >>> found.quantity, round(found.drawn, 3), found.variation < 1e-3
    ('subtending angle', 90.602, True)
    """
    scene = scene_from(scene)
    problem = resolve_design(scene)
    mechanism = problem.setup.mechanism
    if not mechanism.further_contacts or mechanism.has_rib:
        why = "has one contact with the cam: a pair of contacts needs a conjugate pair or a yoke"
        if mechanism.further_contacts:
            why = (
                "has a rib between its rollers: measured ribs are not compared yet, only conjugate pairs and yokes"
            )
        raise BadInput([Mistake(problem.file, "follower", None, why, bare=True)])
    discs = inspect_discs(
        profiles, scene, TableReadingOptions(columns, angle_unit, lift_unit, turn), keep_outliers, aligned
    )
    return _compare_contacts(problem, scene, discs)


def _compare_contacts(problem: Problem, scene: Scene, discs: list[InspectedDisc]) -> PairInspection:
    """Distance and preload of both contacts of a follower on measured discs."""
    setup, start = problem.setup, problem.setup.mechanism.start or (lambda designs: designs.size)
    zero = 0.0 if discs[0].aligned else refine_zero_angle(discs, discs[0].zero)
    first, *others = (disc.cam_angles_at(zero) for disc in discs)
    second = others[0] if others else np.mod(first + np.pi, 2.0 * np.pi)  # of the one disc in a yoke
    angles = np.unique(np.concatenate([first, second]))

    def sum_over_contacts(values_by_disc: Sequence[FloatArray]) -> FloatArray:
        both = zip((first, second), [*values_by_disc] * 2, strict=False)
        return np.asarray(sum(np.interp(angles, *each, period=2.0 * np.pi) for each in both))

    errors = sum_over_contacts([disc.smooth_motion_errors_at(zero) for disc in discs])
    first_phase, *other_phases = (disc.phase_deg for disc in discs)
    turned = (other_phases[0] - first_phase + 180.0) % 360.0 - 180.0 if other_phases else 0.0
    reason = _mismatch_reason(problem, discs, errors, turned)
    # along the motion
    distance = float(
        (start(problem.design) + start(second_disc_designs(problem.design)) + problem.programme.lift)[0]
    )
    unit, tolerance = degrees(1.0) if setup.angular else 1.0, scene.whole_part.profile_tolerance
    responses = [disc.profile_and_bore_responses[0] for disc in discs]
    return PairInspection(
        scene,
        tuple(disc.build_inspection() for disc in discs),
        turned,
        "subtending angle"
        if setup.angular
        else "breadth"
        if setup.mechanism.flat_faced
        else "distance of the rollers",
        "deg" if setup.angular else "mm",
        unit * distance,
        None if tolerance is None else unit * tolerance * float(sum_over_contacts(responses).max()),
        np.degrees(angles),
        unit * errors + (np.nan if reason else 0.0),
        scene.drive.interference or 0.0,
        None if reason else _preload_at_errors(problem, errors),
        _required_preload(problem, angles),
        reason,
    )


def _mismatch_reason(problem: Problem, discs: list[InspectedDisc], errors: FloatArray, turned_deg: float) -> str:
    """Why the discs do not hold one follower; empty if they do."""
    far = [str(place) for place, disc in enumerate(discs, 1) if disc.is_far_from_drawing]
    if far:
        matches = "do not match" if len(far) > 1 else "does not match"
        return f"disc {' and disc '.join(far)} {matches} this drawing"
    if np.abs(errors).max() > WRONG_CAM_SHARE * problem.programme.lift:
        turned = f"disc 2 is turned by {number_text(turned_deg)} deg against disc 1"
        return f"{turned}: their points have not one angle 0"
    return ""


def _preload_at_errors(problem: Problem, distance_errors: FloatArray) -> FloatArray | None:
    """Preload with errors of the contacts' distance [N or N·m]."""
    dynamics = problem.setup.dynamics
    if dynamics.pair_stiffness is None or dynamics.pair_preload is None:
        return None
    preload = dynamics.pair_preload + dynamics.pair_stiffness * distance_errors
    return np.asarray(preload * (1e-3 if problem.setup.angular else 1.0))  # N·mm to N·m


def _required_preload(problem: Problem, angles: FloatArray) -> FloatArray | None:
    """Preload that keeps both contacts at cam angles [N or N·m]."""
    if force.missing_force_keys(problem.setup):
        return None
    record = force.follower_force_curve(problem.setup, problem.design, problem.programme)
    forces = curve_value(record, 0, problem.programme.state(angles))
    return np.asarray(np.abs(forces) / 2.0 * (1e-3 if problem.setup.angular else 1.0))  # N·mm to N·m
