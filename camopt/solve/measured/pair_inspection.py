"""A measured cam with two contacts of its follower: how far apart it holds them, and what is left of the preload.

Each contact is moved by e more than is asked, as of its own motion (``measured.inspection``), so that both together
need by

    s(θ) = e₁(θ) + e₂(θ),    of a yoke e(θ) + e(θ + π)

more than the follower has between them, wherever it is: by so much the subtending angle of two arms, the distance
of two rollers along the motion, or the breadth of a disc in its yoke is off (``mechanisms.pairs``). Mounted with an
interference δ₀ against the stiffness k, each contact presses at rest with

    P(θ) = k·(δ₀ + s(θ))

and where δ₀ + s is below 0 there is a clearance as large. A force F along the motion is shared by both, so that one
lets go where |F|/2 > P (``effects.preload``). F is that of the motion that is asked.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_of
from camopt.model.effects import force
from camopt.model.mechanisms.pairs import second_discs
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.tolerances import tolerance_zone
from camopt.solve.measured.columns import TableColumns
from camopt.solve.measured.inspection import WRONG_CAM_SHARE, InspectedDisc, Inspection, inspect_discs, refine_zero
from camopt.solve.measured.outline import ANGLE_DIGITS
from camopt.solve.measured.profile import MeasuredProfile
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table


class Extreme(NamedTuple):
    """A number of a turn and the cam angle where it is."""

    value: float
    at_deg: float


@dataclass(frozen=True)
class PairInspection(Result):
    """A measured cam with two contacts of its follower against its drawing.

    Attributes
    ----------
    scene : Scene
        The drawing.
    discs : tuple of Inspection
        Each measured disc as a cam of its own, turned on the shaft as it fits best itself, with errors of its own
        motion, which is reversed at the second one; a yoke has one. Behind a train they are of the follower.
    turned : float
        By how much disc 2 is ahead of disc 1, deg; 0 of a yoke.
    quantity : str
        What both contacts are apart: ``subtending angle``, ``distance of the rollers`` along the motion, or
        ``breadth``.
    unit : str
        Of it: deg or mm.
    drawn : float
        What the drawing has of it.
    allowed : float or None
        By how much it may be off either way, if each profile may be off by its tolerance; None where it has none.
    angles : ndarray
        Cam angles, deg, in their order.
    off : ndarray
        By how much the discs hold the contacts further apart there than is drawn; below 0 nearer.
    interference : float
        With which the follower is mounted; 0 where the scene has none.
    preload : ndarray or None
        With what both contacts press at rest, N (N·m); below 0 they do not. None where the stiffness is not known.
    needed : ndarray or None
        What keeps both contacts at the speed of the scene, N (N·m): half of the force. None where it is not known.
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
        """Where the contacts are held the nearest to each other, beyond what is drawn."""
        return self._least_extreme(self.off)

    @property
    def most(self) -> Extreme:
        """Where they are held the furthest apart."""
        place = int(np.argmax(self.off))
        return Extreme(float(self.off[place]), float(self.angles[place]))

    @property
    def variation(self) -> float:
        """Over the turn, from the least to the most."""
        return self.most.value - self.least.value

    @property
    def within(self) -> bool | None:
        """Whether it is off by no more than is allowed; None where nothing is said of that."""
        return None if self.allowed is None or self.reason else bool(np.abs(self.off).max() <= self.allowed)

    @property
    def left(self) -> Extreme:
        """The least interference that is left, deg or mm; below 0 the largest clearance."""
        return self._least_extreme(self.interference + self.off)

    @property
    def spare(self) -> Extreme | None:
        """The least preload beyond what is needed, N (N·m): below 0 a contact lets go. None if it is not known."""
        if self.preload is None or self.needed is None:
            return None
        return self._least_extreme(self.preload - self.needed)

    def _least_extreme(self, values: FloatArray) -> Extreme:
        place = int(np.argmin(values))
        return Extreme(float(values[place]), float(self.angles[place]))

    def table(self) -> Table:
        """What both contacts are apart, and what is left of interference and preload."""
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
        """The least and the most of values over the turn, each with its cam angle."""
        places = int(np.argmin(values)), int(np.argmax(values))
        return [
            text for k in places for text in (with_unit(float(values[k]), unit), number_text(float(self.angles[k])))
        ]

    @property
    def _force_unit(self) -> str:
        return "N·m" if self.unit == "deg" else "N"

    @property
    def _note(self) -> str:
        """What the table does not say, a sentence each."""
        left, spare = self.left, self.spare
        told = [*self._turn_in_words, f"The {self.quantity} varies by {with_unit(self.variation, self.unit)}"]
        if self.within is not None:
            told.append(f"{'Within' if self.within else 'Beyond'} what the tolerance of the profile allows")
        if self.interference and self.allowed is not None and self.allowed >= self.interference:
            clearance = with_unit(self.allowed - self.interference, self.unit)
            told.append(f"That tolerance leaves the worst pair a clearance of {clearance}")
        if left.value > 0.0:
            told.append(f"At rest both contacts press, with at least {with_unit(left.value, self.unit)}")
        else:
            lost = "the preload is lost there" if self.interference else "the follower has so much play there"
            told.append(
                f"A clearance of {with_unit(-left.value, self.unit)} at {number_text(left.at_deg)} deg: {lost}"
            )
        if spare is not None and left.value > 0.0:
            rest = f"{with_unit(abs(spare.value), self._force_unit)} of preload are"
            lets_go = f"a contact lets go at {number_text(spare.at_deg)} deg: {rest} missing"
            told.append(f"At its speed {lets_go if spare.value < 0.0 else f'none lets go: {rest} spare'}")
        return "".join(f"{each}. " for each in told).rstrip()

    @property
    def _turn_in_words(self) -> list[str]:
        turned = abs(round(self.turned, ANGLE_DIGITS))
        if not turned:
            return []
        way = "ahead of" if self.turned > 0.0 else "behind"
        tolerance = self.scene.tolerances.disc_phase
        if tolerance is None:
            allowed = "what the keyway allows"
        else:
            zone = tolerance_zone(tolerance, "disc_phase", 0.0)
            held = zone.lower <= self.turned <= zone.upper
            allowed = f"{'within' if held else 'beyond'} tolerances.disc_phase"
        return [f"Disc 2 is turned by {number_text(turned)} deg against disc 1, {way} it: {allowed}"]

    def sections(self) -> Iterator[Table]:
        """The table of each disc, and that of both."""
        for disc in self.discs:
            yield disc.table()
        yield self.table()

    def document(self) -> dict[str, Any]:
        """What is found of each disc, and of both."""
        return {
            "scene": self.scene.name,
            "discs": [each.document() for each in self.discs],
            "pair": self.records(),
        }

    def records(self) -> dict[str, Any]:
        """The numbers of the pair by name, without what is of each disc; None where it has a reason."""
        about = {
            "quantity": self.quantity,
            "unit": self.unit,
            "drawn": self.drawn,
            "allowed": self.allowed,
            "turned_deg": self.turned,
            "interference": self.interference,
            "reason": self.reason,
        }
        found = {
            "least": self.least._asdict(),
            "most": self.most._asdict(),
            "variation": self.variation,
            "within": self.within,
            "left": self.left._asdict(),
            "preload_least": None if self.preload is None else float(self.preload.min()),
            "spare": self.spare and self.spare._asdict(),
        }
        return about | (dict.fromkeys(found) if self.reason else found)


@options_by_keyword
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
    """Find how far apart a measured conjugate pair, or the disc in a yoke, holds both contacts of its follower.

    Points of both discs are in one frame, that of the drawing as seen from its front: with the axis of the bore at
    0, 0 and one angle 0, as they are measured in one clamping, or from the keyway. Each disc is turned to where its
    own errors are least, and the pair to where those of both are, unless it is aligned: an angle between the discs
    is no error of a profile, but one of what both contacts are apart.

    Parameters
    ----------
    profiles : sequence of MeasuredProfile
        Points of the first and of the second disc; of a yoke those of its one disc.
    scene : Scene, str or os.PathLike
        The drawing: a scene with sizes of its own whose follower has two contacts.
    columns : sequence of str or int, optional
        Names or numbers (from 1) of the columns of all profiles, as for ``inspect``.
    angle_unit : str, default "deg"
        "deg" or "rad".
    lift_unit : str, optional
        "mm" or "inch", of the lengths.
    turn : float, optional
        The angle of one turn of the cam in the files.
    keep_outliers : bool, default False
        Whether single points that are far off their neighbours count for the errors too.
    aligned : bool, default False
        Whether the angle 0 of the points is that of the scene.

    Returns
    -------
    PairInspection
        The variation of what the contacts are apart, the clearance or interference that is left, and its preload.

    Raises
    ------
    BadInput
        As ``inspect``; of a follower with one contact, or another number of profiles than the cam has discs.
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
        why = "has one contact with the cam: a pair of contacts is that of a conjugate pair or a yoke"
        if mechanism.further_contacts:
            why = (
                "has a rib between its rollers: measured ribs are not compared yet, only conjugate pairs and yokes"
            )
        raise BadInput([Mistake(problem.file, "follower", None, why, bare=True)])
    discs = inspect_discs(
        profiles, scene, TableColumns(columns, angle_unit, lift_unit or "mm", turn), keep_outliers, aligned
    )
    return _ContactPair(problem, scene, discs).build_inspection()


@dataclass(frozen=True)
class _ContactPair:
    """Both contacts of a follower on measured discs."""

    problem: Problem
    scene: Scene
    discs: list[InspectedDisc]

    def build_inspection(self) -> PairInspection:
        """What is told of them."""
        angular = self.problem.setup.angular
        unit, tolerance = degrees(1.0) if angular else 1.0, self.scene.whole_part.profile_tolerance
        return PairInspection(
            self.scene,
            tuple(each.build_inspection() for each in self.discs),
            self.phase_difference,
            self._distance_name,
            "deg" if angular else "mm",
            unit * self._drawn_distance,
            None
            if tolerance is None
            else unit * tolerance * float(self._sum_over_contacts(self._profile_responses).max()),
            np.degrees(self.angles),
            unit * self.distance_errors + (np.nan if self._mismatch_reason else 0.0),
            self.scene.drive.interference or 0.0,
            None if self._mismatch_reason else self._preload,
            self._needed_preload,
            self._mismatch_reason,
        )

    @property
    def phase_difference(self) -> float:
        """By how much the second disc is ahead of the first, deg."""
        first, *others = (disc.phase_deg for disc in self.discs)
        return (others[0] - first + 180.0) % 360.0 - 180.0 if others else 0.0

    @property
    def _mismatch_reason(self) -> str:
        """Why the discs do not hold one follower."""
        far = [str(place) for place, disc in enumerate(self.discs, 1) if disc.is_far_off]
        if far:
            are = "are no cams" if len(far) > 1 else "is no cam"
            return f"disc {' and disc '.join(far)} {are} of this drawing"
        if np.abs(self.distance_errors).max() > WRONG_CAM_SHARE * self.problem.programme.lift:
            turned = f"disc 2 is turned by {number_text(self.phase_difference)} deg against disc 1"
            return f"{turned}: their points have not one angle 0"
        return ""

    @cached_property
    def shared_zero(self) -> float:
        """The angle of the points at which both discs together are on the shaft, rad."""
        first = self.discs[0]
        return 0.0 if first.aligned else refine_zero(self.discs, first.zero)

    @property
    def _contact_angles(self) -> list[FloatArray]:
        """Cam angles of the points at each contact, rad; of a yoke those of its one disc, and half a turn later."""
        first, *others = (disc.cam_angles_at(self.shared_zero) for disc in self.discs)
        return [first, *others] if others else [first, np.mod(first + np.pi, 2.0 * np.pi)]

    @cached_property
    def angles(self) -> FloatArray:
        """The cam angles of all points, rad."""
        return np.unique(np.concatenate(self._contact_angles))

    def _sum_over_contacts(self, values: Sequence[FloatArray]) -> FloatArray:
        """The sum at both contacts of what is known at the points of each disc."""
        both = zip(self._contact_angles, [*values] * 2, strict=False)
        return np.asarray(sum(np.interp(self.angles, *each, period=2.0 * np.pi) for each in both))

    @cached_property
    def distance_errors(self) -> FloatArray:
        """s, mm (rad)."""
        return self._sum_over_contacts([disc.smooth_errors_at(self.shared_zero) for disc in self.discs])

    @property
    def _profile_responses(self) -> list[FloatArray]:
        """How far each disc moves its contact by a profile that stands out by 1 mm, mm (rad)."""
        return [disc.responses[0] for disc in self.discs]

    @property
    def _distance_name(self) -> str:
        if self.problem.setup.angular:
            return "subtending angle"
        return "breadth" if self.problem.setup.mechanism.flat_faced else "distance of the rollers"

    @property
    def _drawn_distance(self) -> float:
        """What the contacts are apart along the motion, mm (rad)."""
        first, lift = self.problem.design, self.problem.programme.lift
        start = self.problem.setup.mechanism.start or (lambda designs: designs.size)
        return float((start(first) + start(second_discs(first)) + lift)[0])

    @property
    def _preload(self) -> FloatArray | None:
        dynamics = self.problem.setup.dynamics
        if dynamics.pair_stiffness is None or dynamics.pair_preload is None:
            return None
        return np.asarray(
            (dynamics.pair_preload + dynamics.pair_stiffness * self.distance_errors) * self._force_factor
        )

    @property
    def _needed_preload(self) -> FloatArray | None:
        problem = self.problem
        if force.missing_force_keys(problem.setup):
            return None
        record = force.follower_force_curve(problem.setup, problem.design, problem.programme)
        found = value_of(record, 0, problem.programme.state(self.angles))
        return np.asarray(np.abs(found) / 2.0 * self._force_factor)

    @property
    def _force_factor(self) -> float:
        """Of N (N·mm) in N (N·m)."""
        return 1e-3 if self.problem.setup.angular else 1.0
