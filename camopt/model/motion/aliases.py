"""Other names of laws and segments: those of textbooks, German ones of VDI 2143, and short English ones.

Sources: VDI 2143 Blatt 1, by its quotations in papers and programs; Volmer, Getriebetechnik: Kurvengetriebe;
for textbook names R. S. Khurmi, J. K. Gupta, Theory of Machines, chapter Cams, and lectures on it.
"""

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches

from camopt.core.mistakes import ALIKE_SHARE, suggest_names
from camopt.model.motion import LAWS

ALIASES: dict[str, tuple[str, ...]] = {
    "uniform": ("uniform-velocity", "constant-velocity", "linear", "gerade"),
    "parabolic": (
        *("uniform-acceleration", "uniform-acceleration-and-retardation", "uniform-acceleration-and-deceleration"),
        *("uniform-acceleration-and-uniform-retardation", "constant-acceleration", "parabola"),
        "quadratische-parabel",
    ),
    "cubic": ("poly23", "2-3-polynomial", "polynom-3-grades"),
    "harmonic": ("shm", "simple-harmonic", "einfache-sinoide"),
    "cycloidal": ("cycloid", "bestehorn-sinoide", "geneigte-sinoide", "sinoide-von-bestehorn"),
    "poly345": ("3-4-5-polynomial", "polynom-5-grades"),
    "poly4567": ("4-5-6-7-polynomial", "polynom-7-grades"),
    "modified-trapezoid": ("modifiziertes-beschleunigungstrapez",),
    "modified-sine": ("modifizierte-sinoide",),
    "poly56789": ("5-6-7-8-9-polynomial", "polynom-9-grades"),
    "modified-constant-velocity": ("mcv50",),
}
"""Other names of each law."""
SEGMENT_ALIASES: dict[str, tuple[str, ...]] = {
    "rise": ("outstroke", "outward stroke", "ascent", "lift"),
    "dwell": ("rest",),
    "return": ("return stroke", "inward stroke", "descent", "fall"),
    "move": (),
    "constant-velocity": ("uniform velocity",),
}
"""Other names of each kind of segment."""
LAST_WORDS = re.compile("(motion|period|stroke)$")


def _comparable_letters(name: str) -> str:
    """A name in small letters and digits only, without "and", "equal" and ``LAST_WORDS``."""
    words = re.findall(r"[^\W_]+", name.lower().replace(".", ""))
    return LAST_WORDS.sub("", "".join(word for word in words if word not in ("and", "equal")))


def _names_by_letters(names: Iterable[str], aliases: Mapping[str, tuple[str, ...]]) -> dict[str, str]:
    return {_comparable_letters(each): name for name in names for each in (name, *aliases.get(name, ()))}


_LAWS, _SEGMENTS = _names_by_letters(LAWS, ALIASES), _names_by_letters(SEGMENT_ALIASES, SEGMENT_ALIASES)


def canonical_law_name(name: str) -> str:
    """A law's name in scenes, from any of its names; an unknown name is returned unchanged."""
    return name if name in LAWS else _LAWS.get(_comparable_letters(name), name)


def canonical_segment_kind(name: str) -> str:
    """The kind of a segment, from any of its names; an unknown name is returned unchanged."""
    return _SEGMENTS.get(_comparable_letters(name), name)


def suggest_law_names(name: str, known: Iterable[str]) -> str:
    """The end of a message on an unknown law: the known law with the most similar name, or all known laws."""
    by_letters = _names_by_letters(known := (*known,), ALIASES)
    close = get_close_matches(_comparable_letters(name), by_letters, n=1, cutoff=ALIKE_SHARE)
    return suggest_names(by_letters[close[0]] if close else name, known)
