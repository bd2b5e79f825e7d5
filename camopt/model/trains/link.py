"""A link of a train: how an input displacement becomes an output displacement, and back, in any kind of number.

A stage of a train has keys in scenes, and makes one or two links of their values.

Displacements are counted from the start position, mm or rad. Formulas take series (``numerics.taylor``): of arrays,
or of other numbers, whose derivatives are those of the motion. Proofs take as exact what a link is made from, also
the numbers of its start position, which are found and rounded.

A link may be made from arrays, as many linkages with a formula for all, from ranges with slopes, which enclose all
linkages of a box (``numerics.sloped_interval.LinkageInterval``), or from series, by what is off of it. Of linkages
among them that cannot be put together no number is known.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from math import inf, isfinite, pi
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.sloped_interval import LinkageInterval, as_sloped_interval, hull_of
from camopt.core.numerics.taylor import Series, Taylor, angle_of, series_quotient, series_root
from camopt.model.trains.sketch import LinkSketch


class AssemblyFault(ValueError):
    """Why a stage cannot be put together, or a train cannot move so far."""


class DeadPoint(NamedTuple):
    """An input beyond which a link does not go on."""

    at: float
    why: str


class Coupler(NamedTuple):
    """The coupler of a link: its transmission angle, and where between the ends of a travel it may be least."""

    angle: Callable[[Any], Any]
    """The acute angle, rad, at an input, mm or rad."""
    places: tuple[Any, ...]
    """Inputs where its cosine is stationary."""

    def least_angle(self, low: Any, high: Any) -> Any:
        """The least angle over a travel of the input."""
        between = (np.minimum(np.maximum(each, low), high) for each in self.places)
        return reduce(np.minimum, map(self.angle, (low, high, *between)))


class Force(NamedTuple):
    """A force in a joint of a link, for each N (N·mm) against the motion that the link gives."""

    name: str
    kind: Literal["joint", "pivot", "guide"]
    """What the link passes on, what a pivot of its own takes, or what a guide takes across its slide."""
    share: Callable[[Series], Series]
    """By the input, 1 (1/mm); above 0 where a coupler is pushed, and what only touches is pressed together."""
    touches: bool = False
    """Whether both sides only touch, so that they are pressed together whichever of them drives."""
    way: Callable[[FloatArray], FloatArray] = np.zeros_like
    """The direction in which it acts by the input, rad: from the slide's motion, of a four-bar from the line of its
    pivots, and else from the motion that the link gives."""


class Link(Protocol):
    """One pairing of an input and an output, mm or rad."""

    @property
    def turns(self) -> tuple[bool, bool]:
        """Whether its input, and its output, is an angle."""
        ...

    @property
    def ends(self) -> tuple[DeadPoint, DeadPoint]:
        """The dead points between which its input stays: the nearest to the start position, below and above."""
        ...

    def forward(self, given: Series) -> Series:
        """The output."""
        ...

    def backward(self, asked: Series) -> Series:
        """The input."""
        ...

    def ratio(self, given: Series) -> Series:
        """The velocity of the output over that of the input, where the input is."""
        ...

    @property
    def couplers(self) -> tuple[Coupler | None, Coupler | None]:
        """Its coupler, if it has one: driven from its input, and from its output, which is the input then."""
        ...

    @property
    def forces(self) -> tuple[Force, ...]:
        """The forces in its joints; none where they take sizes that it does not have."""
        ...

    def sketch(self, given: FloatArray, asked: FloatArray, size: float, *, back: bool = False) -> LinkSketch:
        """Itself in a frame of its own at some inputs and outputs; what has no length of its own goes by a size.

        ``back`` says whether it is driven from its output; its input is what drives it in the sketch all the same.
        """
        ...


RADIAN = pi / 180.0
END_INSETS = 10.0 ** np.arange(-16, -5)
FLAT_TOLERANCE = 1e-15
"""Share of its lengths by which rounding may keep a linkage from a position that it just reaches."""
NO_DEAD_POINTS = DeadPoint(-inf, ""), DeadPoint(inf, "")
"""The ends of a link that has no dead point."""
NO_COUPLERS = None, None


def nearest_ends(places: Iterable[DeadPoint]) -> tuple[DeadPoint, DeadPoint]:
    """The nearest dead points below and above the start position, of angles that come back every turn.

    None is further than half a turn, beyond which nothing that a cam swings goes.
    """
    low, high = (DeadPoint(side * pi, "it has turned by half a turn") for side in (-1.0, 1.0))
    for place, why in places:
        above = place % (2 * pi)
        high = min(high, DeadPoint(above, why))
        low = max(low, DeadPoint(above - 2 * pi, why))
    return low, high


def require_positive(margin: Any, why: Callable[[], str]) -> None:
    """That a number is above 0; of many linkages, or a box of them, nothing is known where it is not.

    Raises
    ------
    Unassembled
        If it is one number, and is not.
    """
    if isinstance(margin, float | int | np.number) and not margin > 0.0:
        raise AssemblyFault(why())


def choose_form(margin: Any, one: Callable[[], Any], other: Callable[[], Any]) -> Any:
    """Numbers or series, one of two forms of them: the first where ``margin`` is above 0."""
    margin = margin.terms[0] if isinstance(margin, Taylor) else margin
    if isinstance(margin, LinkageInterval):
        sides = margin.value.low > 0.0, margin.value.high <= 0.0
        return _combine_terms(
            one(),
            other(),
            lambda a, b: hull_of(as_sloped_interval(a, margin), as_sloped_interval(b, margin), *sides),
        )
    if isinstance(margin, np.ndarray):
        return _combine_terms(one(), other(), lambda a, b: np.where(margin > 0.0, a, b))
    return one() if margin > 0.0 else other()


def _combine_terms(one: Any, other: Any, pick: Callable[[Any, Any], Any]) -> Any:
    """Two series put together, term by term; terms may be series themselves."""
    if not isinstance(one, Taylor):
        return pick(one, other)
    return Taylor([_combine_terms(a, b, pick) for a, b in zip(one.terms, other.terms, strict=True)])


def position_at(formula: Callable[[Series], Series], place: Any) -> Any:
    """The value of a formula at numbers, arrays or ranges."""
    return formula(Taylor([place])).terms[0]


def value_at_start(formula: Callable[[Series], Series], like: Any) -> Any:
    """The value of a formula at 0, of a kind of number as another."""
    return formula(like * 0.0) if isinstance(like, Taylor) else position_at(formula, 0.0)


def value_at_end(formula: Callable[[Series], Series], end: float) -> float:
    """The value of a formula at an end of its range, or so little inside that rounding does not take it beyond."""
    places = end * (1.0 - np.array([0.0, *END_INSETS])) if isfinite(end) else np.array([end])
    with np.errstate(invalid="ignore"):
        found = formula(Taylor([places])).terms[0]
    return float(found[np.isfinite(found) | np.isinf(places)][0])


Vector = tuple[Any, Any]


def acute_angle(one: Vector, other: Vector) -> Any:
    """The acute angle between two directions, rad."""
    (x, y), (u, v) = one, other
    return np.arctan2(abs(x * v - y * u), abs(x * u + y * v))


def square_direction(given: FloatArray) -> FloatArray:
    """The direction of a force square to a motion, rad."""
    return np.zeros_like(given) + pi / 2


def unit_series(series: Series) -> Series:
    """The series of 1, with as many terms as another."""
    return series * 0.0 + 1.0


@dataclass(frozen=True)
class ReversedLink:
    """A link that is driven from its output."""

    link: Link

    @property
    def turns(self) -> tuple[bool, bool]:
        given, asked = self.link.turns
        return asked, given

    @property
    def ends(self) -> tuple[DeadPoint, DeadPoint]:
        low, high = sorted(DeadPoint(value_at_end(self.link.forward, each.at), each.why) for each in self.link.ends)
        return low, high

    def forward(self, given: Series) -> Series:
        return self.link.backward(given)

    def backward(self, asked: Series) -> Series:
        return self.link.forward(asked)

    def ratio(self, given: Series) -> Series:
        return series_quotient(unit_series(given), self.link.ratio(self.link.backward(given)))

    @property
    def couplers(self) -> tuple[Coupler | None, Coupler | None]:
        given, asked = self.link.couplers
        return asked, given

    @property
    def forces(self) -> tuple[Force, ...]:
        return tuple(
            each._replace(share=self._reversed_share(each), way=self._reversed_direction(each))
            for each in self.link.forces
        )

    def _reversed_direction(self, force: Force) -> Callable[[FloatArray], FloatArray]:
        return lambda given: force.way(position_at(self.link.backward, given))

    def _reversed_share(self, force: Force) -> Callable[[Series], Series]:
        """What drives the link's output pushes there with what is asked over the ratio, not against its motion."""
        sign = 1.0 if force.touches else -1.0
        return lambda given: force.share(self.link.backward(given)) * self.ratio(given) * sign

    def sketch(self, given: FloatArray, asked: FloatArray, size: float, *, back: bool = False) -> LinkSketch:
        return self.link.sketch(asked, given, size, back=not back).reversed_sketch


def reversed_link(link: Link) -> Link:
    """A link that is driven from its other end."""
    return link.link if isinstance(link, ReversedLink) else ReversedLink(link)


@dataclass(frozen=True)
class Bar:
    """A bar that turns about the origin, and a second one from its end to a point that moves.

    By the law of cosines the bar is at γ = acos((q² + l² − b²)/(2·l·q)) from the direction to a point at the
    distance q: anticlockwise of it if ``side`` is 1, clockwise if it is −1.
    """

    length: Any
    other: Any
    """The length of the second bar."""
    side: Any
    rest: Any = 0.0
    """What is taken off: the angle in the start position."""

    def angle(self, towards: Series, square: Series) -> Series:
        """The angle of the bar, from the direction to the point and the square of its distance."""
        along = square + (self.length - self.other) * (self.length + self.other)
        across = series_root(square * (self.length * self.length * 4.0) - along * along)
        return towards + angle_of(along, across) * self.side - self.rest


Keys = Mapping[str, Any]
"""The values of a stage by key, mm and deg: those that it needs, and of the others those that are given."""


@dataclass(frozen=True)
class StageKind:
    """A kind of stage."""

    name: str
    words: str
    needs: tuple[str, ...]
    """The keys that it has to have."""
    others: tuple[str, ...]
    """Those that it may have."""
    turns: Callable[[Keys, bool], bool]
    """Whether what it moves is an angle, if what comes to it is one or not."""
    links: Callable[[Keys, bool], Sequence[Link]]
    """Its links from values by key, and whether what comes to it is an angle; raises ``AssemblyFault``."""

    def make_links(self, keys: Keys, turns: bool) -> Sequence[Link]:
        """Its links from values by key, and whether what comes to it is an angle.

        Raises
        ------
        Unassembled
            If a key is missing or is none of its own, or it cannot be put together.
        """
        own = (*self.needs, *self.others)
        if missing := [key for key in self.needs if keys.get(key) is None]:
            raise AssemblyFault(f"{self.words} needs {', '.join(missing)}")
        if strange := [key for key, value in keys.items() if value is not None and key not in own]:
            raise AssemblyFault(f"{self.words} has no {strange[0]}; known: {', '.join(own)}")
        return self.links({key: value for key, value in keys.items() if value is not None}, turns)
