"""The motion laws of the registry: their formulas, peak factors and curves."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from camopt.model.motion import LAWS
from camopt.model.motion.aliases import ALIASES
from camopt.model.motion.law import Law, vdi_motion_task
from camopt.model.motion.programme import LAW_PEAKS, law_peaks, law_peaks_inside_stroke
from camopt.show.drawing.style import FAINT, RC_SETTINGS, SERIES

from .markdown import entry, prose, symbol, table

VERBS = {"displacement": "s", "velocity": "s′", "acceleration": "s″", "jerk": "s‴"}


def formula_of(law: Law) -> str:
    """What the law's module says of it; a member of a family has its formula there."""
    if isinstance(law, ModuleType):
        return prose(law.__doc__)
    return f"A member of the family of [`{family_of(law)}`](#{family_of(law)})."


def family_of(law: Law) -> str:
    """The module of a family's class."""
    return type(law).__module__.rpartition(".")[2]


def families() -> Iterator[str]:
    """The families that laws are members of, with their formulas."""
    members = [law for law in LAWS.values() if not isinstance(law, ModuleType)]
    for family in dict.fromkeys(family_of(law) for law in members):
        yield from ("", f"({family})=", f"## Family {family}", "")
        yield prose(sys.modules[f"camopt.model.motion.{family}"].__doc__)


def all_laws() -> Iterator[str]:
    """Each law with its formula, source, and curves."""
    for name, law in LAWS.items():
        text = (
            f"{formula_of(law)}\n\n![s, s′, s″ and s‴ of {law.TITLE}](pictures/{name}.svg)\n\nSource: {law.SOURCE}."
        )
        if aliases := ALIASES.get(name):
            text += f" Other names: {', '.join(f'`{alias}`' for alias in aliases)}."
        yield from ("", f"## {law.TITLE[0].upper()}{law.TITLE[1:]}")
        yield from entry("law", [name], text)
    yield from families()


def number(value: float) -> str:
    """Six digits, or ∞."""
    return "∞" if np.isinf(value) else f"{value:.6g}"


def peaks() -> Iterator[str]:
    """The peak factors of all laws: between dwells, and inside the stroke."""
    rows = []
    for name, law in LAWS.items():
        between, inside = law_peaks(law), law_peaks_inside_stroke(law)
        factors = [
            number(outer) if outer == inner or np.isclose(outer, inner) else f"{number(outer)} ({number(inner)})"
            for outer, inner in ((float(between[peak]), inside[peak]) for peak in LAW_PEAKS)
        ]
        rows.append((f"{{law}}`{name}`", vdi_motion_task(law), *factors, str(between["jumps"]) or "–"))
    return table(("law", "joins", *map(symbol, ("C_v", "C_a", "C_j")), "jumps"), rows)


def draw(folder: Path) -> None:
    """A picture of each law: s, v, a and j over the unit stroke, one beside the other."""
    for name, law in LAWS.items():
        with rc_context({**RC_SETTINGS, "svg.hashsalt": name, "font.size": 9}):
            figure = Figure(figsize=(9.5, 1.9), layout="constrained")
            for axes, (verb, symbol), colour in zip(figure.subplots(1, 4), VERBS.items(), SERIES, strict=False):
                axes.axhline(0.0, color=FAINT, lw=0.8)
                for start, end in zip(law.BREAKS, law.BREAKS[1:], strict=False):
                    x = np.linspace(start, end, 201)[1:-1]
                    axes.plot(x, getattr(law, verb)(x), color=colour, lw=1.8)
                axes.set(title=f"{verb}, {symbol}", xlim=(0, 1), xticks=(0, 0.5, 1))
            path = folder / f"{name}.svg"
            figure.savefig(path, metadata={"Date": None})
