"""``fastest``: the highest speed up to which a cam holds each limit, and the limit that decides it.

The relative excess e(n) over a limit is ≤ 0 where the limit is held. A speed at which it is broken brackets a root
of e, which Brent's method finds in n², because forces are linear in n². Interval arithmetic then encloses the limit
over all speeds below the root and all cam angles. A speed that breaks the limit there is the next bracket.

Limits without curves have no such enclosure. If their quantities hold a bound at every speed between two at which
they hold it (``Effect.holds_between_speeds``), the verdicts at both ends are the proof. For other limits, samples
of the speed take the place of a proof.

Source: R. P. Brent, Algorithms for Minimization without Derivatives, ch. 4.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import brentq

from camopt.core.mistakes import NOT_REACHED, NOTHING_FEASIBLE, BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray
from camopt.core.quantities.unit_systems import from_shown_unit, unit_in_shown_system
from camopt.model.effects import available_quantities, require_effect
from camopt.model.mechanisms import Designs
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, resolve_design, with_rounding_relative_error
from camopt.scene.problem.settings import with_toleranced_numbers_per_design
from camopt.scene.scene import Scene
from camopt.scene.speed import CRANK_SPEED_KEY, TURNS_OF_CRANK
from camopt.scene.tables import SLOWEST_RPM
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.verdicts.certify import certify_design_and_tolerance_box
from camopt.solve.verdicts.limit_boxes import (
    SPEED_KEY,
    limit_verdict_over_box,
    nominal_toleranced_numbers,
    tolerance_ranges,
)
from camopt.solve.verdicts.limit_verdicts import excesses_of_variants, worst_excesses_over_variants
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

PROVED, PROVED_AT_ENDS, UNPROVED = "proved", "not proved between", "not proved"
SPEED_STEP, SPEED_STEPS = 2.0**0.25, 40
"""Ratio of the speeds at which a limit is first tried, and their number on each side of the scene's speed."""
SPEED_MARGINS = tuple(10.0**power for power in range(-9, -3))
"""Relative distances from the highest speed at which its limit is certified, the first that succeeds."""
SAMPLED_SPEEDS = 256
"""Speeds at which a limit is tried if no proof covers the speeds between."""
MOST_BRACKETS = 32
LARGEST_EXCESS = 1e6
"""In place of an infinite excess, for the search of a root."""
STENCIL = 1e-4 * np.array([-2.0, -1.0, 1.0, 2.0])
"""Relative steps of the speed for the slope of the excess."""
CENTRAL_WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12e-4


@dataclass(frozen=True)
class SpeedLimit:
    """The highest speed up to which a cam holds one limit.

    Attributes
    ----------
    limit : str
        Name of the limit, its key in ``[limits]``; limits that every cam has, such as ``undercut``, have no key.
    relation : str
        How the limited quantity must compare with the bound; empty for a limit that every cam has.
    bound : float
        The bound, in ``unit``.
    unit : str
        Unit of the bound.
    rpm : float or None
        Highest speed up to which the limit is held [rev/min]: infinite if no speed breaks it, None if no speed was
        found that holds it.
    rpm_per_unit : float or None
        Gain of this speed per unit of the bound [rev/min per unit], for small changes.
    rpm_per_percent : float or None
        Gain of this speed if the bound rises by 1 % of its magnitude, to first order [rev/min].
    is_held_at_scene_speed : bool
        Whether the limit is held at the speed of the scene.
    proof : str
        "proved": held at all speeds up to it, and broken just above it; "not proved between": only its ends are
        proved, with samples between them; or "not proved". With "to n rev/min", n is the highest speed tried.

    Examples
    --------
    >>> limit = camopt.fastest(camopt.find_scene("valve-with-rocker")).limits[0]
    >>> limit.limit, round(limit.rpm, 2), round(limit.rpm_per_percent, 3), limit.proof
    ('acceleration', 1648.47, 8.242, 'proved')
    """

    limit: str
    relation: str
    bound: float
    unit: str
    rpm: float | None
    rpm_per_unit: float | None
    rpm_per_percent: float | None
    is_held_at_scene_speed: bool
    proof: str


@dataclass(frozen=True)
class Fastest(Result):
    """The highest speed of one cam, with the highest speed of each limit.

    For cams on one shaft, divide ``rpm`` and ``from_rpm`` by the turns of each cam in a turn of the shaft. All of
    them hold their limits from the largest ``from_rpm`` to the smallest ``rpm``.

    Attributes
    ----------
    scene : Scene
        The cam.
    from_rpm : float or None
        Lowest speed of the answer [rev/min]: that of the scene; 1e-9, a cam at rest, if a limit is broken at the
        speed of the scene; else another speed at which all limits are held. None without such a speed.
    limits : tuple of SpeedLimit
        The limits, from the lowest of their highest speeds upwards.

    Examples
    --------
    >>> result = camopt.fastest(camopt.find_scene("valve-with-rocker"))
    >>> result.from_rpm, round(result.rpm, 2), result.deciding_limit
    (1000.0, 1648.47, 'acceleration')
    """

    scene: Scene
    from_rpm: float | None
    limits: tuple[SpeedLimit, ...]
    main_rows: ClassVar[str] = "limits"

    @property
    def rpm(self) -> float | None:
        """Highest speed of the cam up to which all limits are held [rev/min]; infinite, or None, as for a limit."""
        if self.from_rpm is None or any(limit.rpm is None for limit in self.limits):
            return None
        return min((limit.rpm for limit in self.limits if limit.rpm is not None), default=inf)

    @property
    def deciding_limit(self) -> str:
        """Name of the limit that is broken above the highest speed; empty without one."""
        return self.limits[0].limit if self.rpm not in (None, inf) else ""

    @property
    def exit_code(self) -> int:
        """0 if the highest speed is proved, 1 if no speed holds all limits, 4 if a limit is not proved."""
        if self.rpm is None:
            return NOTHING_FEASIBLE
        return 0 if all(limit.proof.startswith(PROVED) for limit in self.limits) else NOT_REACHED

    @property
    def notes(self) -> tuple[str, ...]:
        """A note on velocities per second, which would give a scene of another speed another motion."""
        timed = [f"motion.{number}.per" for number, each in enumerate(self.scene.motion, 1) if each.per == "s"]
        why = "the cam keeps its motion, that of the speed of the scene, at all speeds"
        return (f"{', '.join(timed)} = 's': {why}",) if timed else ()

    def sections(self) -> Iterator[Table | str]:
        """The answer in a sentence, the limits that are broken already, and the table of all limits."""
        yield self.answer
        yield self.table()

    @property
    def answer(self) -> str:
        """Sentences on the highest speed, and on limits that are broken at the speed of the scene."""
        assert self.scene.cam.rpm is not None
        broken = [limit.limit for limit in self.limits if not limit.is_held_at_scene_speed]
        already = f"Broken at {self._speed_text(self.scene.cam.rpm)}: {', '.join(broken)}." if broken else ""
        if self.rpm is None or self.from_rpm is None:
            return f"No speed was found that holds all limits. {already}".strip()
        start = "rest" if self.from_rpm == SLOWEST_RPM else self._speed_text(self.from_rpm)
        if self.rpm == inf:
            return f"All limits are held at any speed from {start}. {already}".strip()
        most = f"All limits are held from {start} to {self._speed_text(self.rpm)}."
        return f"{most} Above this speed {self.deciding_limit} is broken. {already}".strip()

    def table(self) -> Table:
        """A row for each limit: its highest speed, and how much this speed gains with the bound."""
        whose = "the crankshaft" if self.scene.is_speed_of_crank else "the cam"
        note = f"Speeds are those of {whose} in rev/min. Gains are derivatives, for small changes of the bound."
        rows, turns = list[dict[str, str]](), self._shaft_turns_per_cam_turn
        for limit in self.limits:
            speed = "none" if limit.rpm is None else "any" if limit.rpm == inf else number_text(turns * limit.rpm)
            row = {
                "limit": limit.limit,
                "value": f"{limit.relation} {with_unit(limit.bound, limit.unit)}" if limit.relation else "",
                "highest speed": speed,
                "gain": "",
                "gain per 1 %": self._shaft_speed_gain_text(limit.rpm_per_percent),
                "proof": limit.proof,
            }
            if limit.rpm_per_unit is not None:
                gain = self._shaft_speed_gain_text(from_shown_unit(limit.rpm_per_unit, limit.unit))
                row["gain"] = f"{gain} per {unit_in_shown_system(limit.unit) or 'unit'}"
            rows.append(row)
        names = ("limit", "value", "highest speed", "gain", "gain per 1 %", "proof")
        return replace(table_of(f"{self.scene.name}: highest speed of each limit", rows, names), note=note)

    def values_for_json(self) -> dict[str, Any]:
        """The answer, and a record for each limit; speeds are those of the cam."""
        values = {"scene": self.scene.name, "rpm": self.rpm, "from_rpm": self.from_rpm}
        if self.scene.is_speed_of_crank and self.rpm is not None:
            values["rpm_of_crank"] = TURNS_OF_CRANK * self.rpm
        return {**values, "deciding_limit": self.deciding_limit, "limits": [vars(limit) for limit in self.limits]}

    @property
    def _shaft_turns_per_cam_turn(self) -> float:
        """Turns of the shaft whose speed the scene gives, in a turn of the cam."""
        return TURNS_OF_CRANK if self.scene.is_speed_of_crank else 1.0

    def _speed_text(self, rpm: float) -> str:
        shaft = " of the crankshaft" * self.scene.is_speed_of_crank
        return f"{number_text(self._shaft_turns_per_cam_turn * rpm)} rev/min{shaft}"

    def _shaft_speed_gain_text(self, gain: float | None) -> str:
        return "" if gain is None else f"{self._shaft_turns_per_cam_turn * gain:.4g}".replace("-", "−")


def fastest(scene: SceneSource) -> Fastest:
    """Find the highest speed up to which a cam holds all its limits, and the limit that decides it.

    The cam keeps its motion by the cam angle, also if the scene gives velocities per second. All limits are held at
    every speed from that of the scene to the highest speed n. If a limit is broken at the speed of the scene, the
    range begins at rest, or else at another speed at which all limits are held. With ``search.robust`` every cam
    within the tolerances holds the limits.

    Each limit has a highest speed of its own: the root n of its relative excess e(n) over the bound b. The speed
    gains dn/db = −(∂e/∂b)/(∂e/∂n) per unit of the bound.

    Limits on curves are proved in interval arithmetic, at all cam angles and all speeds up to n·(1 − 1e-9), and are
    proved to be broken at n·(1 + 1e-9). Near a bound that the quantity meets at a flat angle, 1e-9 may grow to
    1e-4. Forces in joints, speeds of the lash and motion errors are proved at both ends, which covers all speeds
    between. For other limits, such as those on vibration and on flights across a clearance, only the ends are
    proved; camopt tries 256 speeds between them, and the result says so. Speeds above 1024 times that of the scene
    are not tried.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes and with ``cam.rpm``.

    Returns
    -------
    Fastest
        The highest speed, with that of each limit [rev/min].

    Raises
    ------
    BadInput
        If the scene lacks the speed or a size.

    References
    ----------
    R. P. Brent, Algorithms for Minimization without Derivatives, ch. 4; R. E. Moore, R. B. Kearfott, M. J. Cloud,
    Introduction to Interval Analysis, ch. 11.

    Examples
    --------
    >>> result = camopt.fastest(camopt.find_scene("press-ram-by-four-bar"))
    >>> round(result.rpm, 3), result.deciding_limit, result.exit_code
    (104.182, 'acceleration', 0)
    """
    scene = scene_from(scene)
    if scene.cam.rpm is None:
        why = f"missing; the highest speed is sought from the speed of the scene (or give {CRANK_SPEED_KEY})"
        raise BadInput([Mistake(scene.file, SPEED_KEY, None, why, bare=True)])
    problem = with_rounding_relative_error(resolve_design(scene))
    known = available_quantities(problem.setup.with_numbers({SPEED_KEY: None}))
    fixed = tuple(limit for limit in problem.limits if not {*limit.required_quantities} - {*known})
    names = {limit.name for limit in fixed}
    searches = [SpeedSearch.of_limit(problem, limit.name) for limit in problem.limits if limit.name not in names]
    grid = scene.cam.rpm * SPEED_STEP ** np.arange(-SPEED_STEPS, SPEED_STEPS + 1.0)
    speeds = np.array([scene.cam.rpm])
    held = _limits_held_at_each_speed(searches, speeds)
    own = held[:, 0]
    if not own.all():
        speeds = np.array([scene.cam.rpm, SLOWEST_RPM, *grid[:SPEED_STEPS][::-1], *grid[SPEED_STEPS + 1 :]])
        held = _limits_held_at_each_speed(searches, speeds)
    common = _lowest_speed_that_holds_limits(speeds, held.all(axis=0))
    limits = [_speed_limit_without_speed(problem, limit) for limit in fixed]
    for search, at_scene_speed, each in zip(searches, own, held, strict=True):
        start = _lowest_speed_that_holds_limits(speeds, each) if common is None else common
        limits.append(search.highest_speed_and_gain(start, grid, is_held_at_scene_speed=bool(at_scene_speed)))
    limits.sort(key=lambda limit: -1.0 if limit.rpm is None else limit.rpm)
    return Fastest(scene, common, tuple(limits))


def _limits_held_at_each_speed(searches: "Sequence[SpeedSearch]", speeds_rpm: FloatArray) -> BoolArray:
    """Which limits are held at which speeds (limits, speeds)."""
    return np.array([search.excesses(speeds_rpm) <= 0.0 for search in searches]).reshape(
        len(searches), len(speeds_rpm)
    )


def _lowest_speed_that_holds_limits(speeds_rpm: FloatArray, held: Any) -> float | None:
    """The first of some speeds at which limits are held."""
    return float(speeds_rpm[np.argmax(held)]) if held.any() else None


def _speed_limit_without_speed(problem: Problem, limit: Limit) -> SpeedLimit:
    """The row of a limit that does not depend on the speed."""
    verdict = certify_design_and_tolerance_box(replace(problem, limits=(limit,)))[limit.name]
    rpm, proof = None if verdict == BROKEN else inf, UNPROVED if verdict == UNDECIDED else PROVED
    return SpeedLimit(*_name_relation_bound_and_unit(limit), rpm, None, None, verdict != BROKEN, proof)


def _name_relation_bound_and_unit(limit: Limit) -> tuple[str, str, float, str]:
    """Name, relation, bound and unit of a limit; limits of every cam have neither relation nor unit."""
    unit = "mm" if limit.quantity is None else limit.quantity.unit
    return limit.name, *((limit.relation, limit.bound, unit) if limit.set_by_scene else ("", limit.bound, ""))


@dataclass(frozen=True)
class SpeedSearch:
    """The search for the highest speed of a limit."""

    scene_problem: Problem
    problem: Problem
    """The problem whose designs carry the speed, and numbers with robust tolerances."""
    limit: Limit
    """The limit of ``problem``."""

    @classmethod
    def of_limit(cls, problem: Problem, name: str) -> "SpeedSearch":
        """The search for one limit of a scene's problem, by name."""
        freed = with_toleranced_numbers_per_design(problem).with_keys_per_design([SPEED_KEY])
        (limit,) = (each for each in freed.limits if each.name == name)
        return cls(problem, replace(freed, limits=(limit,)), limit)

    def designs_at(self, speeds_rpm: Sequence[float] | FloatArray) -> Designs:
        """The design at some speeds."""
        designs = self.problem.design.take(np.zeros(len(speeds_rpm), dtype=int))
        return designs.with_values({SPEED_KEY: np.asarray(speeds_rpm, float)})

    def excesses(self, speeds_rpm: Sequence[float] | FloatArray) -> FloatArray:
        """Relative excess over the limit at some speeds: the largest of the cams with errors."""
        with np.errstate(over="ignore"):
            excess = worst_excesses_over_variants(self.problem, [self.limit], self.designs_at(speeds_rpm))[0]
        return np.asarray(np.clip(excess, -LARGEST_EXCESS, LARGEST_EXCESS))

    def highest_speed_and_gain(
        self, start_rpm: float | None, speed_grid_rpm: FloatArray, *, is_held_at_scene_speed: bool
    ) -> SpeedLimit:
        """The highest speed of the limit from a speed that holds it, and what it gains with the bound."""
        rpm, proof = (
            (None, UNPROVED) if start_rpm is None else self.first_broken_speed_and_proof(start_rpm, speed_grid_rpm)
        )
        gain = None if rpm is None or rpm == inf or proof == UNPROVED else self.speed_gain_per_unit_of_bound(rpm)
        by_percent = None if gain is None or not self.limit.bound else gain * abs(self.limit.bound) / 100.0
        words = _name_relation_bound_and_unit(self.limit)
        return SpeedLimit(*words, rpm, gain, by_percent, is_held_at_scene_speed, proof)

    def first_broken_speed_and_proof(self, start_rpm: float, speed_grid_rpm: FloatArray) -> tuple[float, str]:
        """The lowest speed above ``start_rpm`` at which the limit is just held, and how this is proved."""
        search, speeds = self, speed_grid_rpm[speed_grid_rpm > start_rpm]
        over = self.excesses(speeds) > 0.0
        if not over.any():
            broken, proof = self.violating_speed_and_proof_between(start_rpm, speeds[-1])
            if broken is None:
                return inf, f"{proof} to {number_text(float(speeds[-1]))} rev/min"
            search, high = broken
        else:
            high = float(speeds[np.argmax(over)])
        for _ in range(MOST_BRACKETS):
            rpm = search.speed_at_zero_excess(start_rpm, high)
            certified = (  # proved to be held just below the speed, and broken just above it
                margin
                for margin in SPEED_MARGINS
                if search.verdict_at(rpm * (1.0 - margin)) == HELD
                and search.verdict_at(rpm * (1.0 + margin)) == BROKEN
            )
            margin = next(certified, None)
            broken, proof = search.violating_speed_and_proof_between(
                start_rpm, rpm * (1.0 - (margin or SPEED_MARGINS[-1]))
            )
            if broken is None:
                return rpm, proof if margin else UNPROVED
            search, high = broken
        return rpm, UNPROVED

    def speed_at_zero_excess(self, held_rpm: float, broken_rpm: float) -> float:
        """A speed at which the excess passes 0, between two at which it is held and broken."""
        if self.excesses([held_rpm])[0] >= 0.0:
            return held_rpm
        squared = brentq(
            lambda square: self.excesses([square**0.5])[0], held_rpm**2, broken_rpm**2, xtol=1e-300, rtol=1e-14
        )
        return float(squared**0.5)

    def verdict_at(self, rpm: float) -> str:
        """The certificate's verdict on the limit at a speed."""
        problem = self.scene_problem.with_numbers({SPEED_KEY: rpm})
        limits = tuple(limit for limit in problem.limits if limit.name == self.limit.name)
        return certify_design_and_tolerance_box(replace(problem, limits=limits))[self.limit.name]

    def violating_speed_and_proof_between(
        self, low_rpm: float, high_rpm: float
    ) -> "tuple[tuple[SpeedSearch, float] | None, str]":
        """A speed between two that breaks the limit, with its search, or None; and how the limit is proved."""
        if low_rpm >= high_rpm:
            return None, PROVED
        boxes = [{SPEED_KEY: (low_rpm, high_rpm)}]
        if self.problem.zones:
            ranges = {**tolerance_ranges(self.problem, self.designs_at([low_rpm]))}
            least, most = self.speed_error_range
            boxes.append({**ranges, SPEED_KEY: (low_rpm + least, high_rpm + most)})
        verdicts = [
            limit_verdict_over_box(self.problem, self.limit, self.designs_at([low_rpm]), box)
            for box in boxes
            if not self.limit.is_on_motion_error  # its verdict ignores the box
        ]
        if verdicts and all(each.verdict == HELD for each in verdicts):
            return None, PROVED
        for each in verdicts:
            if each.verdict == BROKEN and each.witness is not None:
                search, rpm = self.with_witness_errors_and_speed(each.witness, low_rpm)
                if low_rpm < rpm < high_rpm and search.excesses([rpm])[0] > 0.0:
                    return (search, rpm), UNPROVED
        effects = [require_effect(name, self.problem.setup) for name in self.limit.required_quantities]
        if all(effect.holds_between_speeds for effect in effects):
            return None, PROVED
        samples = np.linspace(low_rpm, high_rpm, SAMPLED_SPEEDS)
        over = self.excesses(samples) > 0.0
        return ((self, float(samples[np.argmax(over)])) if over[1:].any() else None), PROVED_AT_ENDS

    @property
    def speed_error_range(self) -> tuple[float, float]:
        """Least and largest error of the speed within its tolerance [rev/min]."""
        zone = self.problem.zones.get(SPEED_KEY)
        return (0.0, 0.0) if zone is None else (zone.lower, zone.upper)

    def with_witness_errors_and_speed(self, witness: Designs, lowest_rpm: float) -> "tuple[SpeedSearch, float]":
        """The search with the errors of a cam that breaks the limit, and the nominal speed of this cam."""
        values, (_, most) = witness.values, self.speed_error_range
        rpm = max(lowest_rpm, float(values[SPEED_KEY][0]) - most)
        nominal = {**nominal_toleranced_numbers(self.problem, self.designs_at([lowest_rpm])), SPEED_KEY: rpm}
        errors = {field: float(values[field][0]) - at for field, at in nominal.items() if field in values}
        errors = {field: error for field, error in errors.items() if field in self.problem.zones}
        if not errors:
            return self, rpm
        problem = replace(self.problem, robust_errors=(*self.problem.robust_errors, errors))
        return replace(self, problem=problem), rpm

    def speed_gain_per_unit_of_bound(self, rpm: float) -> float | None:
        """Gain of the highest speed per unit of the bound [rev/min per unit], from the excess's derivatives."""
        slope = CENTRAL_WEIGHTS @ self.excesses(rpm * (1.0 + STENCIL)) / rpm
        variants = [*excesses_of_variants(self.problem, [self.limit], self.designs_at([rpm]))]
        variant, columns, _ = max(variants, key=lambda each: float(each[2][0, 0]))
        gain = -float(self.limit.excess_derivative_by_bound(columns, variant)[0]) / slope if slope else inf
        return float(gain) if np.isfinite(gain) else None
