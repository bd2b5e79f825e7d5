"""A link of a train: it turns the displacement of a driver into that of a driven member, and back.

A stage of a train has keys in scenes; one or two links are made from their values.

Displacements count from the start position, in mm or rad. Formulas take Taylor series (``numerics.taylor``), and so
give the derivatives of the motion too. Proofs take the numbers of a link as exact, also those of its start
position, which are computed and rounded.

A link may have one number for each size, or

- arrays: many linkages, computed together;
- ranges with slopes, which enclose all linkages of a box (``numerics.sloped_interval.LinkageInterval``);
- series in the errors of its sizes.

The numbers of linkages that cannot be assembled are undefined.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from math import inf, isfinite, pi
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.sloped_interval import LinkageInterval, as_sloped_interval, choose_form_or_hull
from camopt.core.numerics.taylor import Series, Taylor, series_quotient, series_root, vector_angle
from camopt.model.trains.sketch import LinkSketch


class AssemblyFault(ValueError):
    """A stage cannot be assembled, or a train cannot move as far as it should."""


class DeadPoint(NamedTuple):
    """A position of the driver beyond which a link cannot move."""

    at: float
    why: str


class Coupler(NamedTuple):
    """The coupler of a link, with its transmission angle."""

    angle: Callable[[Any], Any]
    """The transmission angle, acute [rad], by the driver's position [mm or rad]."""
    places: tuple[Any, ...]
    """Positions of the driver where the cosine of the angle is stationary."""

    def least_transmission_angle(self, low: Any, high: Any) -> Number:
        """Least transmission angle over a travel of the driver [rad]."""
        between = (np.minimum(np.maximum(place, low), high) for place in self.places)
        return reduce(np.minimum, map(self.angle, (low, high, *between)))


class Force(NamedTuple):
    """A force in a joint of a link, for a load of 1 N (1 N·mm) against the motion of the driven member."""

    name: str
    kind: Literal["joint", "pivot", "guide"]
    """A force in a joint along the train, on a pivot of the link, or on a guide across its slide."""
    share: Callable[[Series], Series]
    """The force by the driver's position [1 or 1/mm]; positive in a pushed coupler and in a pressed contact."""
    touches: bool = False
    """Whether it is a contact, which is pressed together whichever side drives."""
    way: Callable[[FloatArray], FloatArray] = np.zeros_like
    """Its direction by the driver's position [rad], measured from the slide's motion; in a four-bar from the line
    of pivots, elsewhere from the motion of the driven member."""


class Link(Protocol):
    """A driver and a driven member, each with its displacement [mm or rad]."""

    @property
    def driver_and_driven_angular(self) -> tuple[bool, bool]:
        """Whether the displacement is an angle, of the driver and of the driven member."""

    @property
    def dead_points(self) -> tuple[DeadPoint, DeadPoint]:
        """The dead points of the driver next to its start position, below and above."""

    def driven_displacement(self, driver: Series) -> Series:
        """Displacement of the driven member, from that of the driver."""

    def driver_displacement(self, driven: Series) -> Series:
        """Displacement of the driver, from that of the driven member."""

    def velocity_ratio(self, driver: Series) -> Series:
        """Velocity of the driven member over that of the driver, at a displacement of the driver."""

    @property
    def couplers_by_driving_side(self) -> tuple[Coupler | None, Coupler | None]:
        """Its coupler, if it has one: as driven from the driver's side, and from the other side."""

    @property
    def joint_forces(self) -> tuple[Force, ...]:
        """The forces in its joints; none if they depend on sizes that the link does not have."""

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        """The link in its own frame, at some displacements of both members.

        Parts without a length in the scene are drawn in proportion to ``size``. ``driven_backwards`` says whether
        the train drives the link from its driven member; the input port of the sketch stays at the driver.
        """


RADIAN = pi / 180.0
END_INSETS = 10.0 ** np.arange(-16, -5)
FLAT_TOLERANCE = 1e-15
"""Share of a linkage's lengths by which rounding may keep it from a position that it just reaches."""
NO_DEAD_POINTS = DeadPoint(-inf, ""), DeadPoint(inf, "")
"""The ends of a link that has no dead point."""
NO_COUPLERS = None, None


def nearest_dead_points(places: Iterable[DeadPoint]) -> tuple[DeadPoint, DeadPoint]:
    """The dead points next to the start position, below and above, of angles that repeat every turn.

    The ends are at most half a turn away: no member that a cam swings goes further.
    """
    low, high = (DeadPoint(side * pi, "it has turned by half a turn") for side in (-1.0, 1.0))
    for place, why in places:
        above = place % (2 * pi)
        high = min(high, DeadPoint(above, why))
        low = max(low, DeadPoint(above - 2 * pi, why))
    return low, high


def require_positive(margin: Any, why: Callable[[], str]) -> None:
    """Check that a number is positive; arrays and ranges are not checked.

    Raises
    ------
    AssemblyFault
        If it is a single number and not positive.
    """
    if isinstance(margin, float | int | np.number) and not margin > 0.0:
        raise AssemblyFault(why())


def choose_formula_by_sign(
    margin: Any, positive_formula: Callable[[], Any], other_formula: Callable[[], Any]
) -> Number:
    """The first of two formulas where ``margin`` is positive, else the second; numbers or series."""
    margin = margin.terms[0] if isinstance(margin, Taylor) else margin
    if isinstance(margin, LinkageInterval):
        sides = margin.value.low > 0.0, margin.value.high <= 0.0
        return _combine_series_terms(
            positive_formula(),
            other_formula(),
            lambda a, b: choose_form_or_hull(as_sloped_interval(a, margin), as_sloped_interval(b, margin), *sides),
        )
    if isinstance(margin, np.ndarray):
        return _combine_series_terms(positive_formula(), other_formula(), lambda a, b: np.where(margin > 0.0, a, b))
    return positive_formula() if margin > 0.0 else other_formula()


def _combine_series_terms(one: Any, other: Any, pick: Callable[[Any, Any], Any]) -> Any:
    """Combine two series term by term; terms may be series themselves."""
    if not isinstance(one, Taylor):
        return pick(one, other)
    return Taylor([_combine_series_terms(a, b, pick) for a, b in zip(one.terms, other.terms, strict=True)])


def formula_value_at(formula: Callable[[Series], Series], place: Any) -> Number:
    """The value of a formula of series at numbers, arrays or ranges."""
    return formula(Taylor([place])).terms[0]


def formula_value_at_start(formula: Callable[[Series], Series], sample_number: Any) -> Any:
    """Value of a formula of series at 0, as the same kind of number as ``sample_number``."""
    return formula(sample_number * 0.0) if isinstance(sample_number, Taylor) else formula_value_at(formula, 0.0)


def formula_value_at_end(formula: Callable[[Series], Series], end: float) -> float:
    """The value of a formula at an end of its range, or as near to it as rounding allows."""
    places = end * (1.0 - np.array([0.0, *END_INSETS])) if isfinite(end) else np.array([end])
    with np.errstate(invalid="ignore"):
        values = formula(Taylor([places])).terms[0]
    return float(values[np.isfinite(values) | np.isinf(places)][0])


Vector = tuple[Any, Any]


def acute_angle(one: Vector, other: Vector) -> Number:
    """Acute angle between two directions [rad]."""
    (x, y), (u, v) = one, other
    return np.arctan2(abs(x * v - y * u), abs(x * u + y * v))


def perpendicular_direction(driver: FloatArray) -> FloatArray:
    """Direction of a force square to a motion [rad]."""
    return np.zeros_like(driver) + pi / 2


def constant_one_series(series: Series) -> Series:
    """The series of the constant 1, with as many terms as another."""
    return series * 0.0 + 1.0


@dataclass(frozen=True)
class ReversedLink:
    """A link that is driven at its output: driver and driven member change places."""

    link: Link

    @property
    def driver_and_driven_angular(self) -> tuple[bool, bool]:
        driver_turns, driven_turns = self.link.driver_and_driven_angular
        return driven_turns, driver_turns

    @property
    def dead_points(self) -> tuple[DeadPoint, DeadPoint]:
        low, high = sorted(
            DeadPoint(formula_value_at_end(self.link.driven_displacement, each.at), each.why)
            for each in self.link.dead_points
        )
        return low, high

    def driven_displacement(self, driver: Series) -> Series:
        return self.link.driver_displacement(driver)

    def driver_displacement(self, driven: Series) -> Series:
        return self.link.driven_displacement(driven)

    def velocity_ratio(self, driver: Series) -> Series:
        return series_quotient(
            constant_one_series(driver), self.link.velocity_ratio(self.link.driver_displacement(driver))
        )

    @property
    def couplers_by_driving_side(self) -> tuple[Coupler | None, Coupler | None]:
        forward, backward = self.link.couplers_by_driving_side
        return backward, forward

    @property
    def joint_forces(self) -> tuple[Force, ...]:
        return tuple(
            each._replace(share=self._reversed_force_share(each), way=self._reversed_force_direction(each))
            for each in self.link.joint_forces
        )

    def _reversed_force_direction(self, force: Force) -> Callable[[FloatArray], FloatArray]:
        return lambda driver: force.way(formula_value_at(self.link.driver_displacement, driver))

    def _reversed_force_share(self, force: Force) -> Callable[[Series], Series]:
        """The share when the link is driven at its output.

        The driving force there is the load over the ratio. It acts along the motion, so the sign changes, but not
        that of a contact.
        """
        sign = 1.0 if force.touches else -1.0
        return lambda driver: (
            force.share(self.link.driver_displacement(driver)) * self.velocity_ratio(driver) * sign
        )

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        return self.link.sketch(driven, driver, size, driven_backwards=not driven_backwards).reversed_sketch


@dataclass(frozen=True)
class Bar:
    """A bar l that turns about the origin, and a second bar b from its end to a moving point.

    By the law of cosines the angle between the bar and the direction to a point at the distance q is
    γ = acos((q² + l² − b²)/(2·l·q)). The bar is anticlockwise of that direction if ``side`` is 1, clockwise if −1.
    """

    length: Any
    other: Any
    """Length of the second bar."""
    side: Any
    zero: Any = 0.0
    """The angle in the start position, which is subtracted [rad]."""

    def angle(self, direction_to_point: Series, squared_distance: Series) -> Series:
        """Angle of the bar [rad], from the direction to the point and the square of its distance."""
        along = squared_distance + (self.length - self.other) * (self.length + self.other)
        across = series_root(squared_distance * (self.length * self.length * 4.0) - along * along)
        return direction_to_point + vector_angle(along, across) * self.side - self.zero


Keys = Mapping[str, Any]
"""The values of a stage by key, mm and deg: all required keys, and those optional ones that a scene gives."""


@dataclass(frozen=True)
class StageKind:
    """A kind of stage."""

    name: str
    words: str
    needs: tuple[str, ...]
    """The keys that are required."""
    others: tuple[str, ...]
    """The keys that are optional."""
    turns: Callable[[Keys, bool], bool]
    """Whether its output is an angle, from its keys and whether its input is one."""
    links: Callable[[Keys, bool], Sequence[Link]]
    """Its links, from its keys and whether its input is an angle; raises ``AssemblyFault``."""

    def make_links(self, keys: Keys, input_angular: bool) -> Sequence[Link]:
        """Its links, from its keys and whether its input is an angle.

        Raises
        ------
        AssemblyFault
            If a key is missing or unknown, or the stage cannot be assembled.
        """
        known_keys = (*self.needs, *self.others)
        if missing := [key for key in self.needs if keys.get(key) is None]:
            raise AssemblyFault(f"{self.words} needs {', '.join(missing)}")
        if unknown := [key for key, value in keys.items() if value is not None and key not in known_keys]:
            raise AssemblyFault(f"{self.words} has no {unknown[0]}; known: {', '.join(known_keys)}")
        return self.links({key: value for key, value in keys.items() if value is not None}, input_angular)
