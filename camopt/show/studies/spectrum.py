"""Response spectra of motion laws: vibration of a follower train after one rise, by rise time over natural period.

The rise has lift 1 and takes the time t₁; the train, of natural period T_n and damping ratio ζ, rests before it.
With the period ratio λ = t₁/T_n the response is exact (``numerics.oscillator``, r = 2πλ). Without damping, the
residual amplitude after a cycloidal rise is |sin πλ|/(πλ·|λ² − 1|): 0 for whole λ from 2 on.

Source: Norton, Cam Design and Manufacturing Handbook (residual vibrations).
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.numerics import FloatArray
from camopt.core.numerics.oscillator import damped_frequency_ratio, response_from_rest
from camopt.core.numerics.wave_extremes import wave_maximum, wave_peak_magnitude
from camopt.core.quantities import Quantity
from camopt.core.quantities.display import Drawable
from camopt.core.storage.tables import write_table
from camopt.model.effects.vibration import mass_acceleration_wave, velocity_jump_by_panel
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import DWELL, RISE, Stroke
from camopt.scene.arguments import allow_positional_options
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import DesignRows, concatenate_rows
from camopt.scene.scene import Scene
from camopt.show.drawing.plot import plot
from camopt.show.drawing.style import PAGE_TITLE, Figure, Target, add_grid, new_figure, series_line_style
from camopt.solve.tables.result import Columns, Result, Table, table_of
from camopt.solve.tables.table import schema_of, to_arrow_table

SPECTRUM = ("spectrum.parquet", "spectrum.svg")
DRAWN_LAWS = ("cycloidal", "modified-sine", "modified-trapezoid", "harmonic", "poly345", "poly4567")
PERIOD_RATIOS = np.linspace(0.1, 10.0, 397)  # with all whole numbers and quarters
ALLOWED_RATIOS = (1e-3, 1e4)
PANELS_AT_ONCE = 1 << 14  # panels computed together, each with its own polynomial


SPECTRUM_COLUMNS = {
    name: Quantity(name, symbol, unit, "spectrum", sentence, str if name == "law" else float)
    for name, symbol, unit, sentence in (
        ("law", "", "", "Motion law of the rise."),
        ("period_ratio", "t₁/T_n", "", "Time of the rise over the natural period of the train."),
        ("damping_ratio", "ζ", "", "Damping ratio of the train."),
        ("residual", "A", "lift", "Amplitude of the vibration at the start of the dwell after the rise."),
        ("overshoot", "", "lift", "Largest travel of the mass beyond the lift."),
        ("deflection", "z", "lift", "Largest |x − y| during the rise and after it."),
        ("acceleration", "C_a", "lift/t₁²", "Largest |acceleration| of the mass, with the rise's time as unit."),
    )
}


class Spectrum(Columns, Drawable):
    """A response spectrum: a mapping from names of columns to values.

    Examples
    --------
    >>> camopt.response_spectrum("cycloidal", [1.0, 2.5])["period_ratio"].tolist()
    [1.0, 2.5]
    """

    picture = "studies.spectrum"
    together = True


@allow_positional_options
def response_spectrum(law: str | Law, ratios: ArrayLike | None = None, *, damping_ratio: float = 0.0) -> Spectrum:
    """Compute the vibration of a follower train after one rise, by the ratio t₁/Tₙ of rise time to natural period.

    Parameters
    ----------
    law : str or Law
        The name of a built-in law, or a law.
    ratios : array_like, optional
        Period ratios from 1e-3 to 1e4, in one dimension. Default: 397 ratios from 0.1 to 10, in even steps.
    damping_ratio : float, default 0
        Damping ratio ζ, from 0 to below 1.

    Returns
    -------
    Spectrum
        Columns ``law``, ``period_ratio``, ``damping_ratio``, and in units of the lift: ``residual`` (amplitude at
        the start of the dwell), ``overshoot`` (largest x − 1), ``deflection`` (largest ``|x − y|``) and
        ``acceleration`` (largest ``|ẍ|·t₁²``).

    Raises
    ------
    BadInput
        For an unknown law, or numbers out of range.

    References
    ----------
    R. L. Norton, Cam Design and Manufacturing Handbook (residual vibration).

    Examples
    --------
    >>> spectrum = camopt.response_spectrum("cycloidal", [1.0, 2.5])
    >>> spectrum["residual"].round(4).tolist()
    [0.5, 0.0243]
    """
    mistakes = []
    if isinstance(law, str) and law not in LAWS:
        mistakes.append(Mistake("camopt", "law", law, f"a motion law; {suggest_names(law, LAWS)}"))
    try:
        λ = np.asarray(PERIOD_RATIOS if ratios is None else ratios, dtype=float)
        wrong = λ[~((λ >= ALLOWED_RATIOS[0]) & (λ <= ALLOWED_RATIOS[1]))].tolist()
    except (TypeError, ValueError):
        λ, wrong = np.zeros(0), [ratios]
    allowed = f"numbers from {ALLOWED_RATIOS[0]:g} to {ALLOWED_RATIOS[1]:g}, in one dimension"
    if wrong or λ.ndim != 1:
        mistakes.append(Mistake("camopt", "ratios", wrong[0] if wrong else λ.tolist(), allowed))
    if isinstance(damping_ratio, bool) or not isinstance(damping_ratio, (int, float)) or not 0 <= damping_ratio < 1:
        mistakes.append(Mistake("camopt", "damping_ratio", damping_ratio, "a number, 0 or more and below 1"))
    if mistakes:
        raise BadInput(mistakes)
    chosen = LAWS[law] if isinstance(law, str) else law
    at_once = max(1, PANELS_AT_ONCE // len(_rise_programme(chosen).table.half_width))
    parts = [λ[k : k + at_once].tolist() for k in range(0, len(λ), at_once)]
    responses = [_response_amplitudes(chosen, tuple(part), float(damping_ratio)) for part in parts]
    values = np.concatenate(responses, axis=1) if responses else np.zeros((4, 0))
    names = ("residual", "overshoot", "deflection", "acceleration")
    labels = {"law": np.full(len(λ), chosen.NAME), "period_ratio": λ, "damping_ratio": float(damping_ratio)}
    return _spectrum_of_columns(labels | dict(zip(names, values, strict=True)))


def _spectrum_of_columns(columns: Mapping[str, Any]) -> Spectrum:
    """A spectrum with the units of its columns."""
    return Spectrum(columns, {name: SPECTRUM_COLUMNS[name].unit for name in columns})


@lru_cache(maxsize=64)
def _response_amplitudes(law: Law, ratios: tuple[float, ...], damping_ratio: float) -> FloatArray:
    """Residual, overshoot, deflection and acceleration, (4, ratios)."""
    frequency = 2.0 * np.pi * np.array(ratios)
    programme = _rise_programme(law)
    motion, half_width = programme.table.coefficients.T, np.tile(programme.table.half_width, (len(frequency), 1))
    half_width[:, -1] = np.pi / (damped_frequency_ratio(damping_ratio) * frequency)  # one period of the dwell
    jumps = velocity_jump_by_panel(programme)
    wave = response_from_rest(motion, half_width, jumps, frequency[:, None], damping_ratio)
    beyond = motion.copy()
    beyond[0] -= 1.0
    return np.array(
        [
            wave.amplitude[:, -1],
            np.maximum(wave_maximum(wave.plus_polynomial(beyond)).value, 0.0),
            wave_peak_magnitude(wave).value,
            wave_peak_magnitude(mass_acceleration_wave(wave, frequency[:, None])).value,
        ]
    )


def _rise_programme(law: Law) -> Programme:
    return Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0), Stroke(DWELL, None, 1.0, 1.0, 1.0, 1.0)))


SHOWN_RATIOS = (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)


@dataclass(frozen=True)
class Spectra(Result):
    """The response spectra of several laws."""

    rows: DesignRows

    def table(self) -> Table:
        """A table of the residual amplitude after each law, at a few period ratios."""
        laws: dict[str, dict[str, Any]] = {}
        for record in self.rows.records():
            ratio = round(record["period_ratio"], 9)
            if ratio in SHOWN_RATIOS:
                row = laws.setdefault(record["law"], {"law": record["law"]})
                row[f"{ratio:g}"] = f"{record['residual']:.2g}"
        title = "Residual vibration over the lift, by the ratio t₁/Tₙ of rise time to natural period"
        return table_of(title, [*laws.values()], ["law", *(f"{ratio:g}" for ratio in SHOWN_RATIOS)])

    def values_for_json(self) -> list[dict[str, Any]]:
        """A record for each law and ratio."""
        return self.rows.records()

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Write the table and its picture into a folder, which is created.

        Raises
        ------
        OSError
            If a file cannot be written.
        """
        table, picture = (Path(folder) / name for name in SPECTRUM)
        table.parent.mkdir(parents=True, exist_ok=True)
        write_table(to_arrow_table(self.rows, schema_of(SPECTRUM_COLUMNS.values())), table)
        laws = self.rows.column("law")
        spectra = [
            _spectrum_of_columns({name: self.rows.column(name)[laws == law] for name in SPECTRUM_COLUMNS})
            for law in dict.fromkeys(laws.tolist())
        ]
        plot(spectra, picture)


def spectra_of(scene: Scene) -> Spectra:
    """Spectra of the usual laws and of the laws of a scene, for its damping ratio.

    Raises
    ------
    BadInput
        For a damping ratio of 1 or more.
    """
    problem = resolve(scene)
    laws = {name: LAWS[name] for name in DRAWN_LAWS}
    laws |= {stroke.law.NAME: stroke.law for stroke in problem.programme.tool.strokes if stroke.law}
    damping = problem.setup.dynamics.damping_ratio
    rows = (DesignRows(response_spectrum(law, damping_ratio=damping), len(PERIOD_RATIOS)) for law in laws.values())
    return Spectra(concatenate_rows(rows))


SPECTRUM_TITLES = {
    "residual": "Residual amplitude in the dwell, over the lift",
    "acceleration": "Largest acceleration of the mass, in lift/t₁²",
}
LEAST_AMPLITUDE = 1e-4  # share of the lift: smaller amplitudes are not drawn
AMPLITUDE_TICKS = (1e-4, 1e-3, 1e-2, 0.1, 1.0)


def draw(what: Mapping[str, Any] | Sequence[Mapping[str, Any]], path: Target = None) -> "Figure":
    """Draw response spectra: residual amplitude in the dwell, and largest acceleration of the mass."""
    spectra = [what] if isinstance(what, Mapping) else what
    with new_figure(path, (12.5, 5.6), layout="constrained") as figure:
        damping = {float(each) for spectrum in spectra for each in np.ravel(spectrum["damping_ratio"])}
        ratio = " and ".join(f"{each:g}" for each in sorted(damping))
        title = f"Follower train after a rise in the time t₁: natural period Tₙ, damping ratio {ratio}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        for axes, name in zip(figure.subplots(1, 2), SPECTRUM_TITLES, strict=True):
            _draw_spectra(axes, name, spectra)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=8)
    return figure


def _draw_spectra(axes: Any, name: str, spectra: Sequence[Mapping[str, Any]]) -> None:
    ratios, values = (np.concatenate([each[column] for each in spectra]) for column in ("period_ratio", name))
    for place, spectrum in enumerate(spectra):
        law = str(spectrum["law"][0])
        axes.plot(spectrum["period_ratio"], spectrum[name], lw=1.4, label=law, **series_line_style(place))
    axes.set(xlim=(0.0, ratios.max()), xlabel="period ratio t₁/Tₙ")
    axes.locator_params(axis="x", nbins=11)
    if name == "residual":
        axes.set(yscale="log", ylim=(LEAST_AMPLITUDE, 2.0 * max(1.0, float(values.max()))))
        axes.set_yticks(AMPLITUDE_TICKS, labels=[f"{share:g}" for share in AMPLITUDE_TICKS])
        axes.minorticks_off()
    else:
        axes.set_ylim(0.0, 1.05 * float(values.max()))
    axes.set_title(SPECTRUM_TITLES[name], loc="left")
    add_grid(axes)
