"""Largest velocities and accelerations as in lectures: formula, numbers, answer.

For a stroke S in the cam angle θ at ω: v = c·ωS/θ and a = d·ω²S/θ². Without a speed they are by cam angle (ω = 1).
Source: Khurmi & Gupta, Theory of Machines, ch. 20.
"""

from collections.abc import Iterator
from math import degrees, inf, pi

import numpy as np

from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.motion.programme import law_peaks
from camopt.show.drawing.construction.displacement import displacement_text
from camopt.show.drawing.construction.inversion import Inversion
from camopt.show.drawing.picture import STROKE_NAMES, four_digit_text

FORMULAS: dict[str, tuple[tuple[str, str], tuple[str, str]]] = {
    "uniform": (("ωS/θ", "{w}{s} / {t}"), ("", "")),
    "harmonic": (("πωS/(2θ)", "π × {w}{s} / (2 × {t})"), ("π²ω²S/(2θ²)", "π² × {w}{s} / (2 × {t}²)")),
    "parabolic": (("2ωS/θ", "2 × {w}{s} / {t}"), ("4ω²S/θ²", "4 × {w}{s} / {t}²")),
    "cycloidal": (("2ωS/θ", "2 × {w}{s} / {t}"), ("2πω²S/θ²", "2π × {w}{s} / {t}²")),
}
"""Formulas of the largest velocity and acceleration by law: in symbols, and with places for numbers."""


def cam_speed_and_peak_lines(inversion: Inversion) -> list[str]:
    """Lines of the answers: angular velocity, then velocity and acceleration of each stroke."""
    rpm = inversion.picture.scene.cam.rpm
    speed = (
        [] if rpm is None else [f"ω = 2πN/60 = 2π × {rpm:g}/60 = {four_digit_text(2.0 * pi * rpm / 60.0)} rad/s"]
    )
    return speed + [text for _, text in stroke_peaks_with_text(inversion)]


def stroke_peaks_with_text(inversion: Inversion) -> Iterator[tuple[float, str]]:
    """Velocity and acceleration of each stroke with a law: numbers in the shown unit, and lines of text.

    With a train there are none, since the laws are those of the tool.
    """
    rpm, angular, length = inversion.picture.scene.cam.rpm, inversion.angular, unit_in_shown_system("mm")
    omega, time = (1.0, "rad") if rpm is None else (2.0 * pi * rpm / 60.0, "s")
    metres = time == "s" and length == "mm"
    base = ("rad" if time == "s" else "deg") if angular else "m" if metres else length
    letters = ("ωf", "αf") if angular else ("v", "a")
    for division in inversion.plan.divisions if inversion.problem.programme.tool_programme is None else ():
        stroke = division.stroke
        if stroke is None or stroke.law is None:
            continue
        travel = abs(stroke.high - stroke.low) * (1e-3 if metres and not angular else 1.0)
        travel = travel if angular or metres else to_shown_unit(travel, "mm")
        travel = degrees(travel) if angular and time == "rad" else travel
        peaks, ends = law_peaks(stroke.law), f"{division.start.letter}–{division.end.letter}"
        angle = f"θ = {four_digit_text(degrees(stroke.angle))}° = {four_digit_text(stroke.angle)} rad"
        heading = f"{STROKE_NAMES[stroke.kind]} {ends}, {angle}, S = {four_digit_text(travel)} {base}:  "
        for order, (peak, power) in enumerate((("peak_velocity", ""), ("peak_acceleration", "²"))):
            factor = float(peaks[peak])
            factor_text = four_digit_text(factor)
            general = f"{factor_text} ω{power}S/θ{power}", f"{factor_text} × {{w}}{{s}} / {{t}}{power}"
            symbols, numbers = FORMULAS[stroke.law.NAME][order] if stroke.law.NAME in FORMULAS else general
            label = f"{' ' * 6 if order else heading}{letters[order]} = "
            value = factor * (omega / stroke.angle) ** (order + 1) * travel
            if value == inf:
                yield value, f"{label}0 within the stroke, infinite at its ends"
                continue
            speed = f"{four_digit_text(omega)}{power} × " if time == "s" else ""
            symbols = symbols if speed else symbols.replace("ω²", "").replace("ω", "")
            numbers = numbers.format(w=speed, s=four_digit_text(travel), t=four_digit_text(stroke.angle))
            yield value, f"{label}{symbols} = {numbers} = {four_digit_text(value)} {base}/{time}{power}"


def motion_in_words(inversion: Inversion) -> str:
    """The motion as text: "rise 50 mm in 120°, dwell 30°, …"."""
    lines = []
    for name, start, end in inversion.plan.segments:
        low, high = inversion.problem.programme.motion_at(np.array([start, end]), 0)[0]
        change = "" if name == "dwell" else f" {displacement_text(abs(high - low), inversion.angular)} in"
        lines.append(f"{name}{change} {four_digit_text(degrees(end - start))}°")
    return ", ".join(lines)
