"""Scenes that went wrong: the shipped ones with keys, values, types, structure and bytes changed at random.

The same number gives the same case. A case runs in this process, through the door of the command line.
"""

import io
import re
import signal
import tomllib
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout, suppress
from copy import deepcopy
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import tomli_w

from camopt.cli import exits
from camopt.cli.main import main
from camopt.core.mistakes import LONGEST_LINE
from camopt.core.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.scene.sources import shipped_scenes, shipped_toml

SCHEMA = Scene.model_json_schema()
TEXTS = {name: shipped_toml(name) for name in shipped_scenes()}
COMMANDS = {
    "evaluate": (300, ("--json",)),
    "evaluate in tables": (280, ()),
    "certify": (150, ("--json",)),
    "sweep": (120, ("--samples", "3", "--json", "--out", "out")),
    "optimise": (60, ("--seconds", "0.3", "--json")),
    "export": (60, ("out.svg", "--json")),
    "effects": (5, ("--json",)),
    "report": (10, ("--out", "out.html")),
    "evaluate with points": (15, ("--points", "out.csv")),
}
"""Shares of the commands, in thousandths, and their arguments after the scene."""
MACHINE = {
    "materials": {"cam": "steel", "follower": "steel", "face_width": 10.0, "viscosity": 0.01, "roughness": 0.4},
    "part": {"thickness": 12.0, "bore": 10.0},
}
DYNAMICS = {
    "translating": {"mass": 0.5, "spring_rate": 5.0, "preload": 60.0, "natural_frequency": 200.0, "lash": 0.1},
    "oscillating": {"inertia": 0.01, "spring_rate": 5.0, "preload": 60.0, "natural_frequency": 200.0},
}
"""What asks for loads, stresses and a drawing."""
NUMBERS = (0, 0.0, -0.0, 1, -1, 360, 1e-12, 5e-324, 1e9, 1e300, 2**62, -(2**62), float("nan"), float("inf"))
KINDS = (
    *(True, 1, -1.5, "x", [], {}, [[]], [{}], [[[]]], {"a": 1}, [1, "a"], [1.0, 2.0], {"a": {"a": [1]}}),
    tomllib.loads("a = 1979-05-27")["a"],
)
STRINGS = (
    *("", " ", "x", "size", "none", "1", "true", "a" * 3000, "\n", "\t", "\0", "../..", "/dev/zero", "/dev/stdin"),
    *("[bold]x[/bold]", "[/]", "\x1b[31mred", "\u202egnirts", "<script>alert(1)</script>", "%s{0}$x`", "µ°∞🙂é"),
    *("harmonic+cycloidal", "search.base_radius", "nowhere.csv", "s3://b/t", "-x", "[[cam]]", "\ud7ff\uffff"),
)
HUGE = (
    *(
        "a" * 10**5,
        "µ\n" * 10**4,
        [0.0] * 10**5,
        [1, "a"] * 10**4,
        [[0.0, 1.0]] * 10**4,
        [{}] * 3000,
        ["x" * 5000] * 9,
    ),
    {f"key{n}" * 50: n for n in range(2000)},
    {"a" * 10**5: 1},
    10**400,
)
"""What is of a type that may be right, and too much of it."""
MISFITS = (
    *([], [[]], [{}], {}, {"a": 1}, {"a": []}, [1, "a"], ["x", []], [[1.0, []]], [0.5, {}]),
    *(10**400, -(10**400), [10**400], {"start": 10**400, "stop": []}),
)
"""Lists, tables and endless numbers, which belong where few keys are."""
NAN = re.compile(r"(?<![A-Za-z])nan(?![A-Za-z])", re.IGNORECASE)
LONGEST_TOLD = 25_000  # characters of all that a command says


class Hang(BaseException):
    """A case takes longer than it may."""


class Outcome(NamedTuple):
    command: str
    code: int
    faults: tuple[str, ...]
    out: str
    err: str


# --------------------------------------------------------------------------- what goes wrong


def case(number: int) -> tuple[str, bytes]:
    """A command and the text of a scene."""
    random = Random(number)
    (command,) = random.choices(list(COMMANDS), [share for share, _ in COMMANDS.values()])
    data: Any = tomllib.loads(TEXTS[random.choice(list(TEXTS))])
    if command == "sweep":
        sizes = [key for key in ("base_radius", "mean_radius") if key in data["cam"]]
        ranges = {key: {"start": data["cam"][key], "stop": 2 * data["cam"][key]} for key in sizes}
        data["search"] = ranges | data.get("search", {})
    if random.random() < 0.4:
        data |= {key: dict(table) for key, table in MACHINE.items()}
        data["follower"] |= {"dynamics": dict(DYNAMICS[data["follower"]["motion"]])}
        data["cam"].setdefault("rpm", 300.0)
    if random.random() < 0.3:
        data["outputs"] = random.sample(list(QUANTITIES), random.choice((1, 1, 2)))
    for _ in range(random.choice((0, 1, 1, 1, 1, 1, 1, 2, 2, 3, 5))):
        with suppress(LookupError, TypeError, AttributeError, OverflowError, ValueError):  # it cannot be done here
            random.choices(list(CHANGES), list(CHANGES.values()))[0](data, random)
    if random.random() < 0.7:
        with suppress(LookupError, TypeError, AttributeError, OverflowError):
            _close_turn(data["motion"])
    try:
        text = tomli_w.dumps(data).encode()
    except (TypeError, ValueError, UnicodeEncodeError, RecursionError, AttributeError):  # no TOML can say it
        text = TEXTS["roller-1000rpm"].encode()
    return command, damage_bytes(text, random) if random.random() < 0.1 else text


def misfit_case(number: int) -> tuple[str, bytes]:
    """A command and the text of a scene with ``MISFITS`` in its tables, or in tables that it did not have."""
    random = Random(number)
    (command,) = random.choices(list(COMMANDS), [share for share, _ in COMMANDS.values()])
    data: Any = tomllib.loads(TEXTS[random.choice(list(TEXTS))])
    if random.random() < 0.4:
        data |= {key: dict(table) for key, table in MACHINE.items()}
        data["follower"] |= {"dynamics": dict(DYNAMICS[data["follower"]["motion"]])}
    for name in random.sample(list(SCHEMA["properties"]), 3):
        table = {"own": {}} if name == "laws" else [{}] if _rows_of(SCHEMA["properties"][name]) else {}
        data.setdefault(name, table)
    for name in random.sample(("search", "tolerances"), random.choice((0, 0, 1))):
        data[name] = _numbers(random)
    for _ in range(random.choice((1, 1, 1, 2))):
        table, key = random.choice([*keys(data, random), *keys(data, random), *places(data)])
        table[key] = deepcopy(random.choice(MISFITS))
    return command, tomli_w.dumps(data).encode()


def _numbers(random: Random) -> dict[str, Any]:
    """What a table has of numbers of other tables: of each some, with all that it may say of one."""
    tables = {"cam": "Cam", "follower": "Follower", "drive": "Drive", "materials": "Materials"}
    said = {"plus": 0.1, "minus": 0.1, "distribution": "normal", "values": [0.1], "start": 1.0, "stop": 2.0}
    found: dict[str, Any] = {
        name: {key: dict(said) for key in random.sample(list(SCHEMA["$defs"][kind]["properties"]), 3)}
        for name, kind in tables.items()
    }
    found["train"] = {
        "1": {key: dict(said) for key in random.sample(list(SCHEMA["$defs"]["TrainStage"]["properties"]), 3)}
    }
    return found


def _close_turn(motion: Any) -> None:
    """Let the angles add up to a turn, and the lifts to none, or most cases would end there."""
    motion[-1]["angle"] += 360.0 - sum(each["angle"] for each in motion)
    rises, returns = ([each for each in motion if each["segment"] == way] for way in ("rise", "return"))
    returns[-1]["lift"] += sum(each["lift"] for each in rises) - sum(each["lift"] for each in returns)


def places(data: Any) -> list[tuple[Any, Any]]:
    """All values as (table or list, key)."""
    pairs = list(data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ())
    return [(data, key) for key, _ in pairs] + [place for _, value in pairs for place in places(value)]


def keys(data: Any, random: Random, schema: Any = SCHEMA) -> list[tuple[Any, str]]:
    """All keys of the schema as (table, key), in one table of each list; those that are missing are made."""
    found: list[tuple[Any, str]] = []
    for key, below in schema["properties"].items():
        found.append((data, key))
        inner, rows = _table(below), _rows_of(below)
        for named in (data.get(key) or {}).values() if key == "laws" and isinstance(data.get(key), dict) else ():
            found += keys(named, random, SCHEMA["$defs"]["OwnLaw"]) if isinstance(named, dict) else []
        inside = data.get(key) or ([{}] if rows else {})
        inside = random.choice(inside) if isinstance(inside, list) else inside
        if not (inner or rows) or not isinstance(inside, dict) or not (inside or random.random() < 0.1):
            continue
        if not data.get(key):
            data[key] = [inside] if rows else inside
        found += keys(inside, random, inner or rows)
    return found


def nudge(data: Any, random: Random) -> None:
    """A number a little larger or smaller, which is often still a cam."""
    table, key = random.choice([(t, k) for t, k in places(data) if isinstance(t[k], (int, float))])
    table[key] = table[key] * random.choice((random.uniform(0.5, 1.5), 1 + 1e-12, random.uniform(0.98, 1.02)))


def scale(data: Any, random: Random) -> None:
    """A number of another size or sign."""
    table, key = random.choice([(t, k) for t, k in places(data) if isinstance(t[k], (int, float))])
    table[key] = table[key] * random.choice((-1, 1, 1)) * 10.0 ** random.uniform(-9, 9)


def number(data: Any, random: Random) -> None:
    table, key = random.choice([(t, k) for t, k in places(data) if isinstance(t[k], (int, float))])
    table[key] = random.choice(NUMBERS)


def string(data: Any, random: Random) -> None:
    """Another text: one that is known in some place, or one that is meant to hurt."""
    table, key = random.choice([(t, k) for t, k in places(data) if isinstance(t[k], str)])
    table[key] = random.choice([*WORDS, *STRINGS])


def kind(data: Any, random: Random) -> None:
    """A value of another type."""
    table, key = random.choice(places(data))
    table[key] = deepcopy(random.choice(KINDS))


def huge(data: Any, random: Random) -> None:
    """Far more of something than anybody gives: of a value, or of keys."""
    table, key = random.choice([*places(data), *keys(data, random)])
    table[key] = deepcopy(random.choice(HUGE))


def misplace(data: Any, random: Random) -> None:
    """A key of the schema, wherever it is in the tree, with a value of any type."""
    table, key = random.choice(keys(data, random))
    table[key] = deepcopy(random.choice(KINDS))


def drop(data: Any, random: Random) -> None:
    table, key = random.choice(places(data))
    del table[key]


def rename(data: Any, random: Random) -> None:
    table, key = random.choice([(t, k) for t, k in places(data) if isinstance(t, dict)])
    table[random.choice([key + "s", key[:-1], key.upper(), *STRINGS, *WORDS])] = table.pop(key)


def rearrange(data: Any, random: Random) -> None:
    """A list in another order, or some of it once more."""
    lists = [t[k] for t, k in places(data) if isinstance(t[k], list)]
    found = random.choice(lists)
    random.choice(
        [
            found.reverse,
            lambda: random.shuffle(found),
            lambda: found.append(random.choice(found)),
            lambda: found.extend(found * random.choice((1, 9, 300))),
            found.clear,
        ]
    )()


def graft(data: Any, random: Random) -> None:
    """A part of another scene."""
    other = tomllib.loads(TEXTS[random.choice(list(TEXTS))])
    key = random.choice(list(other))
    data[key] = other[key] if not isinstance(other[key], dict) else {**data.get(key, {}), **other[key]}


def deepen(data: Any, random: Random) -> None:
    """A value inside tables or lists."""
    table, key = random.choice(places(data))
    for _ in range(random.choice((1, 2, 9, 50, 200))):
        table[key] = random.choice(([table[key]], {"a": table[key]}))


def add_known_key(data: Any, random: Random) -> None:
    """A key that the scene did not have, with a value of its type."""
    table, properties = data, SCHEMA["properties"]
    while True:
        key = random.choice(list(properties))
        below = _table(properties[key])
        if below is None or not isinstance(table.setdefault(key, {}), dict):
            table[key] = _value(properties[key], random)
            return
        table, properties = table[key], below["properties"]


def add_several_keys(data: Any, random: Random) -> None:
    """Some keys that the scene did not have, as of a machine with loads."""
    for _ in range(random.randint(2, 8)):
        add_known_key(data, random)


CHANGES: dict[Callable[[Any, Random], None], int] = {
    nudge: 90,
    add_known_key: 30,
    scale: 15,
    number: 12,
    string: 12,
    graft: 10,
    add_several_keys: 10,
    drop: 10,
    rearrange: 8,
    kind: 20,
    misplace: 20,
    huge: 5,
    rename: 5,
    deepen: 4,
}


def _schema_alternatives(schema: dict[str, Any]) -> list[dict[str, Any]]:
    """What a part of the schema may be."""
    if "$ref" in schema:
        return _schema_alternatives(SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]])
    return (
        [each for some in schema["anyOf"] for each in _schema_alternatives(some)] if "anyOf" in schema else [schema]
    )


def _table(schema: dict[str, Any]) -> dict[str, Any] | None:
    return next((each for each in _schema_alternatives(schema) if each.get("properties")), None)


def _rows_of(schema: dict[str, Any]) -> dict[str, Any] | None:
    """The tables that a list of the schema is of."""
    return next((_table(each["items"]) for each in _schema_alternatives(schema) if "items" in each), None)


def _value(schema: dict[str, Any], random: Random, depth: int = 0) -> Any:
    """A value that the schema allows, or almost."""
    chosen = random.choice([each for each in _schema_alternatives(schema) if each.get("type") != "null"])
    if "enum" in chosen or "const" in chosen:
        return random.choice(chosen.get("enum") or [chosen["const"]])
    match chosen.get("type"):
        case "number":
            return round(10.0 ** random.uniform(-3, 4), random.randint(0, 6)) * random.choice((1, 1, 1, -1))
        case "integer":
            return random.choice((0, 1, 2, 3, 5, 12, 100))
        case "boolean":
            return random.random() < 0.5
        case "array":
            return [
                _value(chosen.get("items", {}), random, depth + 1) for _ in range(random.choice((0, 1, 1, 1, 2, 5)))
            ]
        case "object" if depth < 4:
            properties = chosen.get("properties", {})
            needed = set(chosen.get("required", ()))
            keys = [key for key in properties if key in needed or random.random() < 0.3]
            return {key: _value(properties[key], random, depth + 1) for key in keys}
    return random.choice(WORDS)


def _words(schema: Any) -> Iterator[str]:
    if isinstance(schema, dict):
        yield from schema.get("properties", {})
        yield from (word for word in schema.get("enum", ()) if isinstance(word, str))
        for value in schema.values():
            yield from _words(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from _words(value)


WORDS = sorted(
    {
        *_words(SCHEMA),
        *QUANTITIES,
        *(t[k] for text in TEXTS.values() for t, k in places(tomllib.loads(text)) if isinstance(t[k], str)),
    }
)


def damage_bytes(text: bytes, random: Random) -> bytes:
    """With some bytes others, gone, or twice."""
    data = bytearray(text)
    for _ in range(random.choice((1, 1, 3, 30))):
        first = random.randrange(len(data) + 1)
        last = min(len(data), first + random.choice((0, 1, 1, 2, 9, 200)))
        new = random.choice(
            (b"", random.randbytes(last - first), bytes(data[first:last]) * 2, b"\xff", b"\n", b'"')
        )
        data[first:last] = new
    return bytes(data)


# --------------------------------------------------------------------------- what comes of it


@contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Seconds of the processor, after which a case is a hang."""

    def ring(*_: Any) -> None:
        raise Hang

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def outcome(command: str, text: bytes, seconds: float) -> Outcome:
    """Run a command on a scene, in a folder of its own, and judge how it ends."""
    out, err = io.StringIO(), io.StringIO()
    name, _, _ = command.partition(" ")
    _, arguments = COMMANDS[command]
    with TemporaryDirectory() as folder, chdir(folder):
        scene = Path("scene.toml")
        scene.write_bytes(text)
        try:
            with redirect_stdout(out), redirect_stderr(err), cpu_limit(seconds):
                code = main([name, str(scene), *arguments])
        except Hang:
            code = -1
        left = [each for each in Path().rglob("*") if each.is_file() and each != scene]
        faults = tuple(_faults(code, out.getvalue(), err.getvalue(), left))
    return Outcome(command, code, faults, out.getvalue(), err.getvalue())


def _faults(code: int, out: str, err: str, left: list[Path]) -> Iterator[str]:
    if code == -1 or "Hang" in err:
        yield "hang"
    elif code not in (0, exits.NOTHING_FEASIBLE, exits.BAD_INPUT, exits.NOT_REACHED):
        yield f"exit code {code}"
    if "Traceback" in out + err or "Warning:" in err:
        yield "traceback"
    if NAN.search(out.replace('"nan', "")):
        yield "NaN"
    if code == exits.BAD_INPUT and (left or out):
        yield f"bad input, and written: {left}"
    if code == exits.BAD_INPUT and not err.strip():
        yield "no message"
    if any(len(line) > LONGEST_LINE or not line.isprintable() for line in err.splitlines()):
        yield "a message that is no printable line"
    if len(err) > LONGEST_TOLD:
        yield f"messages of {len(err)} characters"
    for each in left:
        if each.suffix in (".csv", ".html", ".svg") and NAN.search(each.read_text(encoding="utf-8")):
            yield f"NaN in {each}"
