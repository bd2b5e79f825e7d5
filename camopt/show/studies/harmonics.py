"""Harmonics: the motion over one turn as a sum of waves, each a whole number of times as fast as the cam.

    y(θ) = a₀ + Σ A_k·cos(kθ − φ_k),    A_k·e^{−iφ_k} = (1/π)∫ y·e^{−ikθ} dθ

The harmonics of the acceleration excite a train, at k times the frequency of the turn. On each panel, the motion is
a polynomial in Legendre form, and the integral is exact: ∫ P_n(u)·e^{−izu} du = 2·(−i)ⁿ·j_n(z). Where the velocity
jumps, the acceleration has an impulse, which is included.

Source: Rothbart, Cam Design Handbook (harmonic analysis of cam motion); DLMF 10.54.2 for the integral.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import scipy
from numpy.polynomial import legendre, polynomial

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.panels import TABLE_DEGREE
from camopt.core.quantities import displacement_unit
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.model.motion.programme import Programme
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.show.drawing.style import PAGE_TITLE, Figure, Target, add_grid, new_figure, series_line_style
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of

DEFAULT_ORDERS, MOST_ORDERS = 24, 10_000
ROUNDING = 1e-14  # share of the largest amplitude: a smaller amplitude is rounding, and set to 0


@dataclass(frozen=True)
class Harmonics(Result, Drawable):
    """The harmonics of a motion, from the first order on.

    Attributes
    ----------
    scene : Scene
        The scene of the motion.
    order : ndarray
        Orders: frequencies in multiples of the cam's.
    frequency_Hz : ndarray or None
        Frequencies [Hz]; None for a scene without rpm.
    mean : float
        Mean displacement above the lowest position [mm or deg].
    displacement : ndarray
        Amplitudes of the displacement [mm or deg].
    phase_deg : ndarray
        Phase of the maximum of each harmonic, from 0 to 360 [deg]; arbitrary for amplitude 0.
    acceleration : ndarray
        Amplitudes of the acceleration, in ``acceleration_unit``.
    acceleration_unit : str
        m/s² or rad/s²; without rpm mm/rad² or deg/rad².

    Examples
    --------
    >>> found = camopt.harmonics(camopt.find_scene("two-pauses"), orders=3)
    >>> found.order.tolist(), found.displacement.shape
    ([1, 2, 3], (3,))
    """

    scene: Scene
    order: Any
    frequency_Hz: FloatArray | None  # noqa: N815
    mean: float
    displacement: FloatArray
    phase_deg: FloatArray
    acceleration: FloatArray
    acceleration_unit: str

    picture = "studies.harmonics"
    main_rows = "harmonics"

    def __repr__(self) -> str:
        return f"<Harmonics of {self.scene.name}: {len(self.order)} orders>"

    def values_for_json(self) -> dict[str, Any]:
        """The mean displacement, and a record for each harmonic."""
        about = {"scene": self.scene.name, "mean": self.mean, "acceleration_unit": self.acceleration_unit}
        return {**about, "harmonics": self.records()}

    def records(self) -> list[dict[str, Any]]:
        """A record for each harmonic."""
        names = ["order", "frequency_Hz", "displacement", "phase_deg", "acceleration"]
        columns = {name: getattr(self, name).tolist() for name in names if getattr(self, name) is not None}
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    def table(self) -> Table:
        """A table with a row for each harmonic."""
        rows = self.records()
        units = {
            "frequency_Hz": "Hz",
            "displacement": displacement_unit(angular=self.scene.tool_turns),
            "phase_deg": "deg",
            "acceleration": self.acceleration_unit,
        }
        mean = with_unit(self.mean, units["displacement"])
        title = f"{self.scene.name}: harmonics of the motion (mean displacement {mean})"
        return table_of(title, rows, rows[0], units=units)


def harmonics(scene: SceneSource, orders: int = DEFAULT_ORDERS) -> Harmonics:
    """Compute the first harmonics of a scene's motion and of its acceleration.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        The scene; its sizes have no influence.
    orders : int, default 24
        Number of harmonics, from 1 to 10,000.

    Returns
    -------
    Harmonics
        Amplitudes and phases, exact to rounding of the lift (acceleration: of its largest value).

    Raises
    ------
    BadInput
        If ``orders`` is not allowed.

    References
    ----------
    H. A. Rothbart, Cam Design Handbook (harmonic analysis).

    Examples
    --------
    >>> found = camopt.harmonics(camopt.find_scene("roller-1000rpm"))
    >>> round(float(found.frequency_Hz[2]), 6), found.acceleration_unit
    (50.0, 'm/s²')
    """
    scene = scene_from(scene)
    if isinstance(orders, bool) or not isinstance(orders, int) or not 1 <= orders <= MOST_ORDERS:
        raise BadInput([Mistake("camopt", "orders", orders, f"a whole number from 1 to {MOST_ORDERS:,}")])
    problem = resolve(scene)
    setup, programme = problem.setup, problem.programme.tool
    order = np.arange(1, orders + 1)
    waves = _fourier_integrals(programme, 0, np.arange(orders + 1)) / programme.unit_in_mm_or_rad
    return Harmonics(
        scene,
        order,
        None if setup.omega is None else order * setup.rpm / 60,
        float(waves[0].real) / 2,
        np.abs(waves[1:]),
        np.degrees(np.angle(waves[1:].conj())) % 360.0,
        np.abs(_fourier_integrals(programme, 2, order)) * motion_unit_factor(setup, 2),
        motion_table_unit(setup, 2),
    )


def _fourier_integrals(programme: Programme, derivative: int, orders: Any) -> Any:
    """(1/π)∫ f·e^{−ikθ} dθ over the turn for each order k; f is the motion or a derivative by the cam angle."""
    table = programme.table
    half = table.half_width
    powers = polynomial.polyder(table.coefficients.T, derivative) / half**derivative
    series = _power_to_legendre_matrix()[:, : len(powers)] @ powers
    integrals: Any = np.array(
        [np.sum(half * np.exp(-1j * k * table.centre) * _panel_integrals(series, k * half)) for k in orders]
    )
    for jump in programme.corners if derivative == 2 else ():
        integrals += jump.size * np.exp(-1j * orders * jump.at)
    return np.where(np.abs(integrals) > ROUNDING * np.abs(integrals).max(), integrals / np.pi, 0.0)


def _panel_integrals(legendre_series: FloatArray, scaled_frequencies: FloatArray) -> Any:
    """∫ f(u)·e^{−izu} du over [−1, 1] for each panel; f in Legendre form, (degrees, panels)."""
    degrees = np.arange(len(legendre_series))[:, None]
    return np.sum(
        2.0 * (-1j) ** degrees * legendre_series * scipy.special.spherical_jn(degrees, scaled_frequencies), axis=0
    )


@cache
def _power_to_legendre_matrix() -> FloatArray:
    """Matrix from powers of u to Legendre polynomials."""
    columns = [legendre.poly2leg(np.eye(TABLE_DEGREE + 1)[k]) for k in range(TABLE_DEGREE + 1)]
    return np.array([np.pad(c, (0, TABLE_DEGREE + 1 - len(c))) for c in columns]).T


LEAST_DRAWN_SHARE = 1e-6  # share of the largest amplitude: smaller amplitudes are not drawn


def draw(what: "Harmonics", path: Target = None) -> "Figure":
    """Draw the amplitudes of displacement and acceleration by order."""
    unit = displacement_unit(angular=what.scene.tool_turns)
    amplitudes = (
        (f"Displacement, {unit_in_shown_system(unit)}", to_shown_unit(what.displacement, unit)),
        (
            f"Acceleration, {unit_in_shown_system(what.acceleration_unit)}",
            to_shown_unit(what.acceleration, what.acceleration_unit),
        ),
    )
    with new_figure(path, (12.5, 5.0), layout="constrained") as figure:
        title = f"{what.scene.name}: harmonics of the motion"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        for axes, (name, values) in zip(figure.subplots(1, 2), amplitudes, strict=True):
            _draw_amplitudes(axes, name, what, values)
    return figure


def draw_main_diagram(axes: Any, what: "Harmonics") -> None:
    """Draw the amplitudes of the displacement in axes."""
    unit = displacement_unit(angular=what.scene.tool_turns)
    _draw_amplitudes(
        axes, f"Displacement, {unit_in_shown_system(unit)}", what, to_shown_unit(what.displacement, unit)
    )


def _draw_amplitudes(axes: Any, title: str, what: "Harmonics", amplitudes: Any) -> None:
    largest = float(np.max(amplitudes))
    seen = amplitudes > LEAST_DRAWN_SHARE * largest
    floor = 10.0 ** np.floor(np.log10(amplitudes[seen].min()))
    axes.vlines(what.order[seen], floor, amplitudes[seen], lw=2.0, color=series_line_style(0)["color"])
    axes.plot(what.order[seen], amplitudes[seen], ls="", marker="o", ms=4.0, color=series_line_style(0)["color"])
    turn = "" if what.frequency_Hz is None else f", in multiples of {what.frequency_Hz[0]:.6g} Hz"
    axes.set(yscale="log", xlim=(0.0, float(what.order[-1]) + 1.0), xlabel=f"harmonic{turn}")
    axes.set_ylim(floor, 2.0 * largest)
    tens = 10.0 ** np.arange(round(np.log10(floor)), np.floor(np.log10(2.0 * largest)) + 1)
    axes.set_yticks(tens, labels=[f"{each:g}" for each in tens])
    axes.minorticks_off()
    axes.set_title(title, loc="left")
    add_grid(axes)
