"""The free flight of a follower from one flank of a positive drive to the other.

While the follower is on a flank, the contact gives it the force F along the motion (``effects.force``). Where F
changes its sign that flank cannot give it: the follower flies until the other flank takes it. With u its way beyond
the prescribed displacement, by the cam angle,

    m·ω²·u'' + c·ω·u' + k·u = −F(θ),    on the flanks u = −e₁ and u = e₂,    e = ½·j/(l·cos β)

with the clearance j along the common normal, and l the length of an arm, or 1. Walls of a groove are parallels of
one pitch curve, with one β; where the follower of a rib swings, each flank has its own, and so e₁ and e₂. The flank
at −e is left where the force that it gives, F − (m·ω²·e'' + c·ω·e' + k·e), is 0, and the other one is met at the
speed ω·l·(u' − e'). The motion is a series of powers on each panel, which the equation gives term by term. Bends of
the pitch curve within the clearance, j·κ ≪ 1, count for nothing.

A force that turns round soon again may bring the follower back to the flank that it left. Where F changes its sign
while the follower flies, no other flight begins.
"""

from functools import lru_cache
from itertools import pairwise
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BISECTIONS, BoolArray, FloatArray, IntArray
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.numerics.state import State
from camopt.model.effects.force import force_series
from camopt.model.motion.programme import Programme

NEGLIGIBLE_FORCE = 1e-9  # of the largest force: less is none
FLIGHT_TERMS = 24  # of a series
SERIES_STEP = 2.0  # of a series: its length times the frequency of the follower on its spring
STEP_FRACTIONS = np.arange(1, 9) / 8.0  # of a step, at which flanks are looked for
MOST_FLIGHT_STEPS = 2000
LARGEST_DEPARTURE_LAG = 0.05  # rad: how far that may be from where F is 0
LIFTED_SHARE = 1e-9  # of the clearance: what is no further from a flank has not left it
SLOPE_STEP = 1e-5  # rad, of a slope


class FlankCrossings(NamedTuple):
    """Where F changes its sign over a turn: each an array (crossings,)."""

    angle: FloatArray
    """Cam angle from which the other sign holds, rad."""
    panel: IntArray
    """The panel that begins or goes on there."""
    side: FloatArray
    """The sign of F before."""
    jump: FloatArray
    """F just after it, N (N·mm), where F jumps; else 0."""
    slope: FloatArray
    """Its slope by the cam angle just after it."""


@lru_cache(maxsize=64)
def find_flank_crossings(programme: Programme, factors: tuple[float, ...]) -> FlankCrossings:
    """The crossings of F with its factors (``force.force_factors``) over a turn without corners."""
    table, series = programme.table, force_series(programme, factors)[:, 0]
    bound = float(np.abs(polynomial.polyval(np.linspace(-1.0, 1.0, 9), series)).max())
    roots: dict[int, list[float]] = {}
    for panel, u in sign_changes(series):
        roots.setdefault(panel, []).append(u)
    signs, starts = [], []
    for panel in range(table.centre.size):
        edges = [-1.0, *sorted(roots.get(panel, ())), 1.0]
        for low, high in pairwise(edges):
            middle = float(polynomial.polyval((low + high) / 2.0, series[:, panel]))
            if abs(middle) > NEGLIGIBLE_FORCE * bound:
                signs.append(np.sign(middle))
                starts.append((panel, low))
    found = [k for k in range(len(signs)) if signs[k] != signs[k - 1]]
    panels = np.array([starts[k][0] for k in found], dtype=np.int64)
    places = np.array([starts[k][1] for k in found])
    here = series[:, panels]
    after = np.asarray(polynomial.polyval(places, here, tensor=False))
    slope = polynomial.polyval(places, polynomial.polyder(here), tensor=False) / table.half_width[panels]
    return FlankCrossings(
        table.centre[panels] + places * table.half_width[panels],
        panels,
        np.array([-signs[k] for k in found]),
        np.where(np.abs(after) > NEGLIGIBLE_FORCE * bound, after, 0.0),
        np.asarray(slope),
    )


class Flights(NamedTuple):
    """Flights (flights,) of designs from one flank: what each starts with."""

    design: IntArray
    setting: IntArray
    """The row of the forces of each."""
    angle: FloatArray
    panel: IntArray
    side: FloatArray
    slope: FloatArray
    jump: FloatArray


class Followers(NamedTuple):
    """What flies, by setting: mass, t (t·mm²), damping, stiffness, ω; F on panels (powers, settings, panels)."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    omega: FloatArray
    force: FloatArray


class Landings(NamedTuple):
    """Where each flight ends: cam angle, rad, and panel; its length, rad; its speed there, mm (rad) by rad.

    ``crosses`` is whether that is on the other flank: a flight may end on the one where it began.
    """

    angle: FloatArray
    panel: IntArray
    length: FloatArray
    speed: FloatArray
    crosses: BoolArray


class HalfGap(NamedTuple):
    """e, half the clearance along the motion, of designs over the turn: mm, or rad."""

    pressures: tuple[Any, ...]
    """The curves of tan β: of the flank that pushes outward, and of the other one if it has another."""
    half: FloatArray
    """½·j/l of each design."""
    programme: Programme

    def value_and_slope(
        self, design: IntArray, panel: IntArray, u: FloatArray, side: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """e and e' by the cam angle, of designs at places of panels, of the flanks that bear forces with a sign."""
        state = panel_state(self.programme, panel, u)
        each = [value_and_slope(pressure, design, state) for pressure in self.pressures]
        tangent, slope = np.where(side > 0.0, each[0], each[-1])
        secant = np.sqrt(1.0 + np.square(tangent))
        return self.half[design] * secant, self.half[design] * tangent * slope / secant


def panel_state(programme: Programme, panel: IntArray, u: FloatArray) -> State:
    """The motion at places of panels; without jerk and load, which the formulas of sizes do not read."""
    rows, width = programme.table.coefficients[panel].T, programme.table.half_width[panel]
    y, y1, y2 = (polynomial.polyval(u, polynomial.polyder(rows, order), tensor=False) for order in range(3))
    return State(y, y1 / width, y2 / np.square(width), np.zeros_like(y))


def simulate_flights(programme: Programme, followers: Followers, flights: Flights, gap: HalfGap) -> Landings:
    """All flights to the flanks where they end."""
    flying = _departure_states(programme, followers, flights, gap)
    count = flights.design.size
    landed = Landings(
        np.zeros(count), np.zeros(count, np.int64), np.zeros(count), np.zeros(count), np.zeros(count, bool)
    )
    index = np.arange(count)
    for _ in range(MOST_FLIGHT_STEPS):
        if not index.size:
            break
        done, flying = _advance_flights(programme, followers, flights, gap, index, flying, landed)
        index = index[~done]
    return landed


class _FlightState(NamedTuple):
    """The state of flights under way: panel, place on it, cam angle flown, s·u and its derivative by the angle."""

    panel: IntArray
    place: FloatArray
    flown: FloatArray
    way: FloatArray
    speed: FloatArray

    def take(self, index: Any) -> "_FlightState":
        return _FlightState(*(each[index] for each in self))


def _departure_states(programme: Programme, followers: Followers, flights: Flights, gap: HalfGap) -> _FlightState:
    """Where flanks are left: a little before F is 0 or after it, for a flank that the clearance moves.

    Where the jerk jumps at the crossing, neither side may have such a place: then the flank is left just there.
    """
    table, panel, design = programme.table, flights.panel, flights.design
    start = (flights.angle - table.centre[panel]) / table.half_width[panel]
    early, late = (_departure_lag(programme, followers, flights, gap, start, side) for side in (-1.0, 1.0))
    by = np.where(late > 0.0, late, np.minimum(early, 0.0))
    panel, place = _shift_places(programme, panel, start, by)
    half, half1 = gap.value_and_slope(design, panel, place, flights.side)
    return _FlightState(panel, place, np.zeros(design.size), -half, -half1)


def _departure_lag(
    programme: Programme, followers: Followers, flights: Flights, gap: HalfGap, start: FloatArray, side: float
) -> FloatArray:
    """How much after F is 0 a flank is left, rad, by the slopes just before the crossing (−1) or after it (1)."""
    table, own, step = programme.table, flights.setting, np.full(start.size, SLOPE_STEP)
    mass, damping, stiffness, omega = (each[own] for each in followers[:4])
    (near, at), (far, beyond) = (
        _shift_places(programme, flights.panel, start, side * each * step) for each in (1.0, 2.0)
    )
    half, half1 = gap.value_and_slope(flights.design, near, at, flights.side)
    half2 = (gap.value_and_slope(flights.design, far, beyond, flights.side)[1] - half1) / (side * step)
    moved = mass * np.square(omega) * half2 + damping * omega * half1 + stiffness * half
    series = polynomial.polyder(followers.force[:, own, near])
    falling = flights.side * polynomial.polyval(at, series, tensor=False) / table.half_width[near]
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where((flights.jump == 0.0) & (falling < 0.0), moved / falling, 0.0)
    return np.where(np.abs(found) < LARGEST_DEPARTURE_LAG, found, 0.0)


def _shift_places(
    programme: Programme, panel: IntArray, place: FloatArray, by: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Places moved by a cam angle (rad), on the panel before or after if need be."""
    table = programme.table
    edges = table.centre - table.half_width
    angle = np.mod(table.centre[panel] + place * table.half_width[panel] + by, 2.0 * np.pi)
    found = np.maximum(np.searchsorted(edges, angle, side="right") - 1, 0)
    found = np.where(by == 0.0, panel, found)
    where = (angle - table.centre[found]) / table.half_width[found]
    return found, np.where(by == 0.0, place, np.clip(where, -1.0, 1.0))


def _advance_flights(
    programme: Programme,
    followers: Followers,
    flights: Flights,
    gap: HalfGap,
    index: IntArray,
    flying: _FlightState,
    landed: Landings,
) -> tuple[BoolArray, _FlightState]:
    """Fly on to the end of a panel, or as far as a series goes; which flights have ended, and the others."""
    table, own, side = programme.table, flights.setting[index], flights.side[index]
    panel, design, width = flying.panel, flights.design[index], table.half_width[flying.panel]
    mass, damping, stiffness, omega = (each[own] for each in followers[:4])
    fast = np.maximum(np.sqrt(stiffness / mass), damping / mass) / omega
    room = np.maximum((1.0 - flying.place) * width, 0.0)
    length = np.minimum(room, SERIES_STEP / np.maximum(fast, 1e-9))
    pushed = (
        -side
        * _recentre_polynomials(followers.force[:, own, panel], flying.place)
        / _powers_by_row(width, len(followers.force))
    )
    series = _oscillator_series(
        pushed, mass * np.square(omega), damping * omega, stiffness, flying.way, flying.speed
    )

    def flank_gaps(share: Any) -> tuple[FloatArray, FloatArray]:
        """s·u less its value on the other flank, and on the first one: that is met at 0, this left above it."""
        along = share * length
        way = polynomial.polyval(along, series, tensor=False)
        ahead, behind = (
            gap.value_and_slope(design, panel, flying.place + along / width, each)[0] for each in (-side, side)
        )
        return way - ahead, way + behind

    looked = [flank_gaps(share) for share in STEP_FRACTIONS]
    beyond = np.array([one >= 0.0 for one, _ in looked])
    size = gap.value_and_slope(design, panel, flying.place, side)[0]
    back = np.array([two < -LIFTED_SHARE * size for _, two in looked])
    met = beyond | back
    ends = met.any(axis=0)
    first = met.argmax(axis=0)
    low, high = np.where(first > 0, STEP_FRACTIONS[first - 1], 0.0), STEP_FRACTIONS[first]
    returns = back[first, np.arange(index.size)]
    for _ in range(BISECTIONS if ends.any() else 0):
        middle = 0.5 * (low + high)
        one, two = flank_gaps(middle)
        inside = np.where(returns, two >= -LIFTED_SHARE * size, one < 0.0)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    along = np.where(ends, high, 1.0) * length
    way, speed = (polynomial.polyval(along, each, tensor=False) for each in (series, polynomial.polyder(series)))
    place = flying.place + along / width
    _, half1 = gap.value_and_slope(design, panel, place, np.where(returns, side, -side))
    here = index[ends]
    flown = flying.flown + along
    landed.panel[here], landed.length[here] = panel[ends], flown[ends]
    landed.angle[here] = np.mod((table.centre[panel] + place * width)[ends], 2.0 * np.pi)
    landed.speed[here] = np.abs(speed - np.where(returns, -half1, half1))[ends]
    landed.crosses[here] = ~returns[ends]
    over = room <= length
    on = _FlightState(
        np.where(over, (panel + 1) % table.centre.size, panel), np.where(over, -1.0, place), flown, way, speed
    )
    return ends, on.take(~ends)


def _powers_by_row(width: FloatArray, count: int) -> FloatArray:
    """width⁰, width¹, … (count, n)."""
    return np.asarray(width ** np.arange(count)[:, None])


def _recentre_polynomials(series: FloatArray, place: FloatArray) -> FloatArray:
    """Polynomials (powers, n) in powers of u − place."""
    count = len(series)
    found = np.zeros_like(series)
    powers = _powers_by_row(place, count)
    for low in range(count):
        for high in range(low, count):
            found[low] += comb(high, low) * powers[high - low] * series[high]
    return found


def _oscillator_series(
    pushed: FloatArray,
    mass: FloatArray,
    damping: FloatArray,
    stiffness: FloatArray,
    way: FloatArray,
    speed: FloatArray,
) -> FloatArray:
    """The series (terms, n) of x with mass·x'' + damping·x' + stiffness·x = pushed, from x and x' at its start."""
    found = np.zeros((max(FLIGHT_TERMS, len(pushed) + 2), way.size))
    found[0], found[1] = way, speed
    for k in range(len(found) - 2):
        given = pushed[k] if k < len(pushed) else 0.0
        found[k + 2] = (given - damping * (k + 1) * found[k + 1] - stiffness * found[k]) / (
            mass * (k + 2) * (k + 1)
        )
    return found
