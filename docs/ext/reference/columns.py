"""Quantities, effects and symbols, from ``camopt.core.quantities`` and the modules of effects and mechanisms."""

import re
import sys
from collections.abc import Iterator
from functools import cache
from itertools import groupby
from pathlib import Path

from camopt.core.quantities import AT_LEAST, DISCIPLINES, GEOMETRY, QUANTITIES, Quantity
from camopt.model.effects import EFFECTS
from camopt.model.mechanisms import DRIVEN, MECHANISMS
from camopt.scene.scene import SCENE_TABLES
from camopt.show.exporting.cam_points import COLUMN_NOTES, FORM_COLUMNS

from . import keys
from .markdown import entry, prose, symbol, table

ROOT = Path(__file__).parents[3]
THEORY = ROOT / "docs" / "theory"
OTHERS = {
    "limits": "Verdicts on the limits of a scene. They need no effect of their own.",
    "proof": "What later steps add to a row.",
}


def module_of(effect: str) -> str:
    """The module that computes an effect."""
    return EFFECTS[effect].applicable_quantities.__module__


def of_effects() -> Iterator[str]:
    """All quantities by the effect that computes them, with the equations that its module states."""
    by_effect = {effect: [q for q in QUANTITIES.values() if q.effect == effect] for effect in (*EFFECTS, *OTHERS)}
    for effect, found in by_effect.items():
        yield from ("", f"## {effect}", "")
        yield from described(effect) if effect in EFFECTS else [OTHERS[effect], ""]
        for _, alike in groupby(found, lambda q: (q.symbol, q.sentence)):
            yield from of_quantities([*alike])


def described(effect: str) -> Iterator[str]:
    """An effect: what its module says, whose curves it takes, where the theory is, and when it runs."""
    module = sys.modules[module_of(effect)]
    file = module.__name__.replace(".", "/") + ".py"
    yield from (prose(module.__doc__), "")
    curves = sorted(
        {*re.findall(r"mechanism\.(pressure|curvature|reach|outline|profile_radius)\b(?! is)", source_of(file))}
    )
    if curves:
        words = [name.replace("_", " ") for name in curves]
        yield f"The curves of {' and '.join(words)} are those of the [mechanism](mechanisms.md).\n"
    pages = [page for page in sorted(THEORY.glob("*.md")) if file in page.read_text(encoding="utf-8")]
    if pages:
        yield f"Theory: {', '.join(f'{{doc}}`../theory/{page.stem}`' for page in pages)}.\n"
    called = (
        "Runs where a scene names no outputs." if effect in GEOMETRY else f'Called for by `outputs = ["{effect}"]`'
    )
    called = called if effect in GEOMETRY else f"{called}, and by limits and objectives on its quantities."
    yield f"{called} Code: `{file}`.\n"


def source_of(file: str) -> str:
    """The text of a module."""
    return (ROOT / file).read_text(encoding="utf-8")


def of_quantities(alike: list[Quantity]) -> Iterator[str]:
    """Quantities that differ by their unit alone, as one entry."""
    first = alike[0]
    kind = {str: "text", bool: "true or false"}.get(first.kind, "no unit")
    units = ", ".join(dict.fromkeys(q.unit for q in alike if q.unit)) or kind
    facts = [
        f"{symbol(first.symbol)}, **{units}**." if first.symbol else f"**{units}**.",
        symbol(prose(first.sentence)),
    ]
    needs = sorted({key for q in alike for key in keys.missing().get(q.name, ())})
    if needs:
        facts.append(f"Needs {', '.join(key_link(key) for key in needs)}.")
    if first.relation_to_limit:
        facts.append(f"As a limit: {'at least' if first.relation_to_limit == AT_LEAST else 'at most'} so much.")
    if bounds := [key for key in limited() for q in alike if q.name in limited()[key]]:
        facts.append(f"Held by {', '.join(f'{{key}}`limits.{key}`' for key in dict.fromkeys(bounds))}.")
    yield from entry("quantity", [q.name for q in alike], " ".join(facts))


def key_link(key: str) -> str:
    """A link to a key of the scene, or to a table, for those that are documented ones."""
    if key in SCENE_TABLES:
        return f"{{ref}}`[{key}] <table-{key}>`"
    place, _, name = key.rpartition(".")
    known = place in SCENE_TABLES and name in SCENE_TABLES[place].model_fields
    return f"{{key}}`{key}`" if known else f"`{key}`"


@cache
def limited() -> dict[str, set[str]]:
    """The quantities that each limit is compared with."""
    return {key: {name for limit in each for name in limit.shown_quantities} for key, each in keys.limits().items()}


def symbols() -> Iterator[str]:
    """Symbols with the quantities that they stand for; names that differ by a unit or a stroke once."""
    for effect in DISCIPLINES:
        here = sorted((q for q in QUANTITIES.values() if q.symbol and q.effect == effect), key=lambda q: q.symbol)
        rows = []
        for name, alike in groupby(here, lambda q: q.symbol):
            found = [*alike]
            units = ", ".join(dict.fromkeys(q.unit for q in found if q.unit)) or "–"
            meaning = symbol(" ".join(dict.fromkeys(q.sentence for q in found)))
            rows.append((symbol(name), units, meaning, f"{{quantity}}`{found[0].name}`"))
        if rows:
            yield from ("", f"### {effect}")
            yield from table(("symbol", "unit", "meaning", "column"), rows)


def of_points() -> Iterator[str]:
    """Columns of points: those of the turn, and of each curve by what follows its name."""
    rows = [
        (f"`{name}`", unit, said) for name, (unit, said) in COLUMN_NOTES.items() if name.endswith(("_deg", "_mm"))
    ]
    curves = {name: said for name, (_, said) in COLUMN_NOTES.items() if not name.endswith(("_deg", "_mm"))}
    rows += [
        (f"`{curve}_{end}`", unit or "–", f"{said} {more}".strip())
        for curve, said in curves.items()
        for end, (unit, more) in FORM_COLUMNS.items()
    ]
    return table(("column", "unit", "meaning"), rows)


def mechanisms() -> Iterator[str]:
    """Each pairing of cam and follower with its formulas."""
    formulas = [*(each.pressure for each in MECHANISMS.values()), *(each.outline for each in DRIVEN)]
    formulas += [contact.local_designs for each in DRIVEN for contact in each.further_contacts]
    modules = dict.fromkeys(sys.modules[each.__module__] for each in formulas if each)
    for module in modules:
        title, *rest = prose(module.__doc__).split("\n", 1)
        label = module.__name__.rpartition(".")[2].replace("_", "-")
        yield from ("", f"(mechanism-{label})=", f"## {title.removesuffix('.').replace(': ', ', ')}", *rest, "")
        yield f"Code: `{module.__name__.replace('.', '/')}.py`.\n"
