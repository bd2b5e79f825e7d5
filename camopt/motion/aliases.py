"""Other names of the built-in laws: German ones, as in VDI 2143, and short English ones.

Sources: VDI 2143 Blatt 1 (the names of its laws; read through what papers and programs quote of it); Volmer,
Getriebetechnik: Kurvengetriebe.
"""

from camopt.motion import LAWS

ALIASES: dict[str, tuple[str, ...]] = {
    "uniform": ("linear", "constant-velocity", "gerade"),
    "parabolic": ("constant-acceleration", "quadratische-parabel"),
    "cubic": ("poly23", "2-3-polynomial", "polynom-3-grades"),
    "harmonic": ("simple-harmonic", "einfache-sinoide"),
    "cycloidal": ("bestehorn-sinoide", "geneigte-sinoide", "sinoide-von-bestehorn"),
    "poly345": ("3-4-5-polynomial", "polynom-5-grades"),
    "poly4567": ("4-5-6-7-polynomial", "polynom-7-grades"),
    "modified-trapezoid": ("modifiziertes-beschleunigungstrapez",),
    "modified-sine": ("modifizierte-sinoide",),
    "poly56789": ("5-6-7-8-9-polynomial", "polynom-9-grades"),
    "modified-constant-velocity": ("mcv50",),
}
"""Names by that of the law; capitals, spaces and full stops make no difference."""
NAMES = {alias: law for law, aliases in ALIASES.items() for alias in aliases}


def law_named(name: str) -> str:
    """The name that scenes use of a law by any of its names; a name that is none as it is."""
    plain = name.lower().replace(".", "").replace(" ", "-")
    return name if name in LAWS else NAMES.get(plain, plain if plain in LAWS else name)
