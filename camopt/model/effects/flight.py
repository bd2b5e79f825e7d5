"""The free flight of a follower from one flank of a positive drive to the other.

On a flank the contact gives the follower the force F along the motion (``effects.force``). Where F changes its
sign, that flank cannot give it, and the follower flies until it lands on the other flank. Let u be its displacement
beyond the prescribed one. By the cam angle,

    m·ω²·u'' + c·ω·u' + k·u = −F(θ),    on the flanks u = −e₁ and u = e₂,    e = ½·j/(l·cos β)

with the clearance j along the common normal, and the length l of an arm, or 1. The walls of a groove are parallels
of one pitch curve, with one β. On a rib with a swinging follower each flank has its own β, and so e₁ and e₂ differ.
The flight starts where the force from the flank at −e, F − (m·ω²·e'' + c·ω·e' + k·e), is 0. The landing speed is
ω·l·(u' − e'). On each panel the motion is a power series, whose terms follow from the equation. The curvature of
the pitch curve within the clearance is neglected, j·κ ≪ 1.

If the force soon changes its sign again, the follower may land on the flank that it left. No other flight begins
where F changes its sign during a flight.
"""

from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BISECTIONS, BoolArray, FloatArray, IntArray
from camopt.core.numerics.curves import curve_value, value_and_slope
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.numerics.state import State
from camopt.model.effects.force import force_polynomials_by_panel
from camopt.model.effects.panel_parts import motion_polynomials_to_order_2
from camopt.model.motion.programme import JUMP_SIDE, Programme

NEGLIGIBLE_FORCE = 1e-9  # of the largest force: less counts as 0
FLIGHT_TERMS = 24  # number of terms of a series
SERIES_STEP = 2.0  # largest length of a series, times the natural frequency of the follower on its spring
STEP_FRACTIONS = np.arange(1, 9) / 8.0  # of a step, at which the flanks are checked
MOST_FLIGHT_STEPS = 2000
LARGEST_DEPARTURE_LAG = 0.05  # rad: largest distance of the departure from F = 0
LIFTED_SHARE = 1e-9  # of the clearance: a follower this near to a flank has not left it
SLOPE_STEP = 1e-5  # rad: step of a numerical slope


class FlankCrossings(NamedTuple):
    """The changes of sign of F over a turn, as arrays (crossings,)."""

    angle: FloatArray
    """Cam angle of the change [rad]."""
    panel: IntArray
    """The panel that starts at the change or contains it."""
    side: FloatArray
    """The sign of F before the change."""
    slope: FloatArray
    """Slope of F by the cam angle just after the change."""
    jump: FloatArray
    """F just after the change if F jumps there [N or N·mm]; else 0."""


@lru_cache(maxsize=64)
def find_flank_crossings(programme: Programme, factors: tuple[float, ...]) -> FlankCrossings:
    """Changes of sign of F over a turn without corners, from ``force.force_factors_with_train``."""
    table, series = programme.table, force_polynomials_by_panel(programme, factors)[:, 0]
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
    changes = [k for k in range(len(signs)) if signs[k] != signs[k - 1]]
    panels = np.array([starts[k][0] for k in changes], dtype=np.int64)
    places = np.array([starts[k][1] for k in changes])
    here = series[:, panels]
    after = np.asarray(polynomial.polyval(places, here, tensor=False))
    slope = polynomial.polyval(places, polynomial.polyder(here), tensor=False) / table.half_width[panels]
    return FlankCrossings(
        table.centre[panels] + places * table.half_width[panels],
        panels,
        np.array([-signs[k] for k in changes]),
        np.asarray(slope),
        np.where(np.abs(after) > NEGLIGIBLE_FORCE * bound, after, 0.0),
    )


class Flights(NamedTuple):
    """The starts of flights from one flank, as arrays (flights,)."""

    design: IntArray
    setting: IntArray
    """The row of its forces in ``Followers``."""
    angle: FloatArray
    panel: IntArray
    side: FloatArray
    slope: FloatArray
    jump: FloatArray


class Followers(NamedTuple):
    """The followers by setting: mass [t or t·mm²], damping, stiffness, ω, and F (powers, settings, panels)."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    omega: FloatArray
    force: FloatArray


class Landings(NamedTuple):
    """The ends of flights: cam angle [rad], panel, length [rad], and landing speed [mm or rad per rad].

    ``crosses`` says whether the flight ends on the other flank, and not on the one where it began.
    """

    angle: FloatArray
    panel: IntArray
    length: FloatArray
    speed: FloatArray
    crosses: BoolArray


class HalfGap(NamedTuple):
    """Half the clearance along the motion, e, of designs over the turn [mm or rad]."""

    pressures: tuple[Any, ...]
    """The curves of tan β: that of the flank that pushes outward, and that of the other flank if it differs."""
    half: FloatArray
    """½·j/l of each design."""
    programme: Programme

    def value_and_slope(
        self, design: IntArray, panel: IntArray, panel_places: FloatArray, side: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """e and e' of designs at places of panels; ``side`` is the sign of the force that the flank bears."""
        state = motion_state_on_panels(self.programme, panel, panel_places)
        tangents = [value_and_slope(pressure, design, state) for pressure in self.pressures]
        tangent, slope = np.where(side > 0.0, tangents[0], tangents[-1])
        secant = np.sqrt(1.0 + np.square(tangent))
        return self.half[design] * secant, self.half[design] * tangent * slope / secant

    def values_on_both_flanks(
        self, design: IntArray, panel: IntArray, panel_places: FloatArray, side: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """e of designs at places of panels, on the flank of ``side`` and on the other flank."""
        state = motion_state_on_panels(self.programme, panel, panel_places)
        tangents = [curve_value(pressure, design, state) for pressure in self.pressures]
        one, other = (
            self.half[design] * np.sqrt(1.0 + np.square(tangent)) for tangent in (tangents[0], tangents[-1])
        )
        return np.where(side > 0.0, one, other), np.where(side > 0.0, other, one)

    def delay(self, design: IntArray, panel: IntArray, panel_places: FloatArray, side: FloatArray) -> FloatArray:
        """Cam angle from a jump of the acceleration to its arrival at a follower on the flank of ``side`` [rad].

        The flank at y ∓ e(y, y') touches the follower beside the point of the pitch curve at the cam angle, by
        ±∂e/∂y'. (tan β is linear in y'.)
        """
        state = motion_state_on_panels(self.programme, panel, panel_places)
        tangent, next_tangent = (
            np.where(side > 0.0, *(curve_value(self.pressures[k], design, each) for k in (0, -1)))
            for each in (state, state._replace(y1=state.y1 + 1.0))
        )
        secant = np.sqrt(1.0 + np.square(tangent))
        return np.asarray(side * self.half[design] * tangent * (next_tangent - tangent) / secant)


def motion_state_on_panels(programme: Programme, panel: IntArray, panel_places: FloatArray) -> State:
    """The motion at places of panels, without jerk and load, which curves of sizes do not read."""
    y, y1, y2 = (
        polynomial.polyval(panel_places, series[:, panel], tensor=False)
        for series in motion_polynomials_to_order_2(programme)
    )
    return State(y, y1, y2, np.zeros_like(y))


def simulate_flights(programme: Programme, followers: Followers, flights: Flights, gap: HalfGap) -> Landings:
    """Simulate all flights to their landings."""
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
    """The states of flights: panel, place on it, cam angle flown, and s·u with its derivative; s = ±1."""

    panel: IntArray
    place: FloatArray
    flown: FloatArray
    way: FloatArray
    speed: FloatArray

    def take(self, index: Any) -> "_FlightState":
        return _FlightState(*(each[index] for each in self))


def _departure_states(programme: Programme, followers: Followers, flights: Flights, gap: HalfGap) -> _FlightState:
    """The departures from the flanks: a little before or after F = 0, because the flank moves with the clearance.

    If the jerk jumps at the crossing, there may be no departure on either side; the flight then starts at F = 0. If
    the acceleration jumps, it starts where the jump reaches the flank, with the motion after the jump.
    """
    table, panel, design = programme.table, flights.panel, flights.design
    start = (flights.angle - table.centre[panel]) / table.half_width[panel]
    early, late = (
        _angle_from_crossing_to_departure(programme, followers, flights, gap, start, side) for side in (-1.0, 1.0)
    )
    panel, place = _shift_places(programme, panel, start, np.where(late > 0.0, late, np.minimum(early, 0.0)))
    distances_to_jumps = np.abs(flights.angle[:, None] - [jump.at for jump in programme.jumps])
    # a jump of the load alone has no delay
    delayed = (flights.jump != 0.0) & (distances_to_jumps.min(axis=1, initial=np.inf) < JUMP_SIDE)
    place += np.where(delayed, gap.delay(design, panel, place, flights.side), 0.0) / table.half_width[panel]
    half, half1 = gap.value_and_slope(design, panel, place, flights.side)
    return _FlightState(panel, place, np.zeros(design.size), -half, -half1)


def _angle_from_crossing_to_departure(
    programme: Programme, followers: Followers, flights: Flights, gap: HalfGap, start: FloatArray, side: float
) -> FloatArray:
    """Cam angle from F = 0 to the departure [rad], by slopes just before (side −1) or after (1) the crossing."""
    table, setting, step = programme.table, flights.setting, np.full(start.size, SLOPE_STEP)
    mass, damping, stiffness, omega = (values[setting] for values in followers[:4])
    (near, at), (far, beyond) = (
        _shift_places(programme, flights.panel, start, side * steps * step) for steps in (1.0, 2.0)
    )
    half, half1 = gap.value_and_slope(flights.design, near, at, flights.side)
    half2 = (gap.value_and_slope(flights.design, far, beyond, flights.side)[1] - half1) / (side * step)
    flank_force = mass * np.square(omega) * half2 + damping * omega * half1 + stiffness * half
    series = polynomial.polyder(followers.force[:, setting, near])
    falling = flights.side * polynomial.polyval(at, series, tensor=False) / table.half_width[near]
    with np.errstate(divide="ignore", invalid="ignore"):
        lag = np.where((flights.jump == 0.0) & (falling < 0.0), flank_force / falling, 0.0)
    return np.where(np.abs(lag) < LARGEST_DEPARTURE_LAG, lag, 0.0)


def _shift_places(
    programme: Programme, panel: IntArray, place: FloatArray, angle_shift: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Places moved by a cam angle [rad], on another panel if necessary."""
    table = programme.table
    edges = table.centre - table.half_width
    angle = np.mod(table.centre[panel] + place * table.half_width[panel] + angle_shift, 2.0 * np.pi)
    new_panel = np.maximum(np.searchsorted(edges, angle, side="right") - 1, 0)
    new_panel = np.where(angle_shift == 0.0, panel, new_panel)
    new_place = (angle - table.centre[new_panel]) / table.half_width[new_panel]
    return new_panel, np.where(angle_shift == 0.0, place, np.clip(new_place, -1.0, 1.0))


def _advance_flights(
    programme: Programme,
    followers: Followers,
    flights: Flights,
    gap: HalfGap,
    index: IntArray,
    flying: _FlightState,
    landed: Landings,
) -> tuple[BoolArray, _FlightState]:
    """Advance flights by a step: to the end of a panel, or as far as a series converges.

    Returns a mask of the flights that have landed, and the states of the others.
    """
    table, setting, side = programme.table, flights.setting[index], flights.side[index]
    panel, design, width = flying.panel, flights.design[index], table.half_width[flying.panel]
    mass, damping, stiffness, omega = (values[setting] for values in followers[:4])
    frequency = np.maximum(np.sqrt(stiffness / mass), damping / mass) / omega
    to_end = np.maximum((1.0 - flying.place) * width, 0.0)
    length = np.minimum(to_end, SERIES_STEP / np.maximum(frequency, 1e-9))
    driving_force = (
        -side
        * _recentre_polynomials(followers.force[:, setting, panel], flying.place)
        / width ** np.arange(len(followers.force))[:, None]
    )
    series = _oscillator_series(
        driving_force, mass * np.square(omega), damping * omega, stiffness, flying.way, flying.speed
    )

    def distances_to_both_flanks(
        step_fraction: Any, flight_index: Any = slice(None)
    ) -> tuple[FloatArray, FloatArray]:
        """s·u minus its value on the other flank (a landing at 0), and on the first flank (in flight above 0)."""
        along = step_fraction * length[flight_index]
        way = polynomial.polyval(along, series[:, flight_index], tensor=False)
        behind, ahead = gap.values_on_both_flanks(
            design[flight_index],
            panel[flight_index],
            flying.place[flight_index] + along / width[flight_index],
            side[flight_index],
        )
        return way - ahead, way + behind

    size = gap.values_on_both_flanks(design, panel, flying.place, side)[0]
    gaps = np.array([distances_to_both_flanks(share) for share in STEP_FRACTIONS])
    beyond, back = gaps[:, 0] >= 0.0, gaps[:, 1] < -LIFTED_SHARE * size
    landed_by = beyond | back
    ends = np.asarray(landed_by.any(axis=0))
    first = landed_by.argmax(axis=0)
    high = STEP_FRACTIONS[first]
    returns = back[first, np.arange(index.size)]
    if ends.any():
        which = np.flatnonzero(ends)

        def landing_depth(step_fraction: FloatArray) -> FloatArray:
            one, two = distances_to_both_flanks(step_fraction, which)
            return np.where(returns[which], -LIFTED_SHARE * size[which] - two, one)

        high[which] = _root_between(landing_depth, high[which] - STEP_FRACTIONS[0], high[which])
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
    over = to_end <= length
    next_panel = np.where(over, (panel + 1) % table.centre.size, panel)
    return ends, _FlightState(next_panel, np.where(over, -1.0, place), flown, way, speed).take(~ends)


def _root_between(function: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray) -> FloatArray:
    """Roots of functions that are negative at ``low`` and not at ``high``, by the Illinois method."""
    far, last = low, high
    far_value, last_value = function(far), function(last)
    for _ in range(BISECTIONS):
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -last_value * (last - far) / (last_value - far_value)
        place = np.clip(last + np.where(np.isfinite(step), step, 0.0), low, high)
        if np.array_equal(place, last):
            break
        value = function(place)
        crossed = value * last_value < 0.0
        far_value = np.where(crossed, last_value, 0.5 * far_value)
        far = np.where(crossed, last, far)
        last, last_value = place, value
    return last


def _recentre_polynomials(series: FloatArray, place: FloatArray) -> FloatArray:
    """Polynomials (powers, n) in u, written in powers of u − place."""
    count = len(series)
    shifted = np.zeros_like(series)
    powers = place ** np.arange(count)[:, None]
    for low in range(count):
        for high in range(low, count):
            shifted[low] += comb(high, low) * powers[high - low] * series[high]
    return shifted


def _oscillator_series(
    driving_force: FloatArray,
    mass: FloatArray,
    damping: FloatArray,
    stiffness: FloatArray,
    displacement: FloatArray,
    speed: FloatArray,
) -> FloatArray:
    """Series (terms, n) of x, from x and x' at its start: mass·x'' + damping·x' + stiffness·x = driving_force."""
    series = np.zeros((max(FLIGHT_TERMS, len(driving_force) + 2), displacement.size))
    series[0], series[1] = displacement, speed
    for k in range(len(series) - 2):
        force = driving_force[k] if k < len(driving_force) else 0.0
        series[k + 2] = (force - damping * (k + 1) * series[k + 1] - stiffness * series[k]) / (
            mass * (k + 2) * (k + 1)
        )
    return series
