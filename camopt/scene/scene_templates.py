"""Scenes to start from, with a comment for each key, and with further keys and tables switched off.

A line that begins with ``#`` and a key, or with ``#[``, has no effect until its ``#`` is deleted.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import tomli_w

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities.key import NO_UNIT
from camopt.model.mechanisms import MECHANISMS, Mechanism
from camopt.model.mechanisms.elements import FLAT, Tip
from camopt.model.motion import LAWS
from camopt.scene.checks import GUIDE_KEYS
from camopt.scene.machine import MACHINE_TABLES
from camopt.scene.scene import SCENE_TABLES, Scene, find_scene
from camopt.scene.sources import shipped_scenes, shipped_toml
from camopt.scene.table_places import TABLE_LISTS, is_key_of_angular_motion, key_record, table_heading

PURPOSES = {
    "valve": "bucket-valve",
    "rocker": "rocker-valve",
    "feeder": "feeder-with-stop",
    "press": "press-with-drift",
    "lock-bolt": "indexing-overlap",
    "belt": "belt-matching",
    "barrel": "feeder-with-stop",
    "lever": "slide-by-bell-crank",
}
"""Purposes of cams, each with a shipped scene."""
PAIRINGS = {
    f"{mechanism.body.form} {mechanism.motion.name}-{tip.name}": (mechanism, tip)
    for mechanism in MECHANISMS.values()
    for tip in mechanism.tips
}
"""Mechanisms, each with a tip of its follower, by the words of options."""
EXAMPLE_TURN = [
    {"segment": "rise", "angle": 120, "lift": 10, "law": "cycloidal"},
    {"segment": "dwell", "angle": 60},
    {"segment": "return", "angle": 120, "lift": 10, "law": "cycloidal"},
    {"segment": "dwell", "angle": 60},
]
EXAMPLE_SIZE = 40
FLANK_HEIGHTS = ("groove_depth", "rib_height")


def _example_values_by_key(place: str, turns: bool = False) -> dict[str, Any]:
    """The example values of the keys of a table."""
    records = {name: key_record(SCENE_TABLES[place], name) for name in SCENE_TABLES[place].model_fields}
    return {
        name: record.example_of(angular=turns) for name, record in records.items() if record.example is not None
    }


def minimal_scene_tables(mechanism: Mechanism, tip: Tip) -> dict[str, Any]:
    """The tables of a cam and follower with their sizes and a motion, nothing else."""
    own = mechanism.follower_size_keys(tip)
    return {
        "cam": {"form": mechanism.body.form, mechanism.body.size_key: EXAMPLE_SIZE},
        "follower": {
            "motion": mechanism.motion.name,
            "contact": tip.name,
            **{key: value for key, value in _example_values_by_key("follower").items() if key in own},
        },
        "motion": EXAMPLE_TURN,
    }


def further_key_examples_by_table(scene: Scene) -> dict[str, dict[str, Any]]:
    """Example values of further keys, by table of a scene."""
    mechanism, tip = scene.mechanism, scene.tip
    body, size = mechanism.body, getattr(scene.cam, mechanism.body.size_key)
    laws = any(segment.law in LAWS for segment in scene.motion)
    others = {
        key
        for each in MECHANISMS.values()
        if each.motion != mechanism.motion
        for key in each.motion.own_dynamics_keys
    }
    others |= {*GUIDE_KEYS} if mechanism.further_contacts else set()
    drive_keys = (
        mechanism.drive.keys if not mechanism.further_contacts else ()
    )  # a preload excludes a clearance, so neither is shown
    dynamics = _example_values_by_key("follower.dynamics", mechanism.motion.angular)
    seen = {"face_reach": 80} if tip == FLAT else {"pressure_angle": 45}
    bore = {} if scene.cam.shaft_diameter is None else {"bore": scene.cam.shaft_diameter}
    sizes = {} if scene.profile else {body.size_key: {"start": size / 2, "stop": 3 * size, "step": 1}}
    return {
        "cam": _example_values_by_key("cam"),
        "follower.dynamics": {key: value for key, value in dynamics.items() if key not in others},
        "drive": {"kind": mechanism.drive.name}
        | {k: v for k, v in _example_values_by_key("drive").items() if k in drive_keys},
        "limits": {**seen, "curvature_radius": 1, "torque_rms_N_m": 50},
        "search": {
            **sizes,
            **({"law": ["cycloidal", "poly345"]} if laws else {}),
            "minimise": f"{body.size_key}_mm",
        },
        "synthesis": {"minimise": "acceleration"},
        "materials": _example_values_by_key("materials"),
        "part": {
            k: v
            for k, v in (_example_values_by_key("part") | bore).items()
            if k not in FLANK_HEIGHTS or k in body.part
        },
        "accuracy": _example_values_by_key("accuracy"),
    }


def starting_scene(name: str | None = None, form: str | None = None, follower: str | None = None) -> str:
    """The text of a scene to start from, by a purpose or a shipped scene, or by a form of cam and its follower.

    Raises
    ------
    BadInput
        If the name or the mechanism is unknown.
    """
    if name is not None and (form or follower):
        raise BadInput([Mistake("camopt", "name", name, "give either a name, or a form and a follower", bare=True)])
    if name is None:
        data = {"name": "My cam", **minimal_scene_tables(*_mechanism_and_tip(form, follower))}
        return _template_text(Scene.from_dict(data), data, [])
    known = (*PURPOSES, *shipped_scenes())
    if name not in known:
        raise BadInput(
            [Mistake("camopt", "name", name, f"a purpose or a shipped scene; {suggest_names(name, known)}")]
        )
    scene = find_scene(shipped := PURPOSES.get(name, name))
    about = [line for line in shipped_toml(shipped).splitlines() if line.startswith("# ")]
    return _template_text(scene, scene.to_dict(), about)


def starting_machine() -> str:
    """The text of a machine to start from: three shipped scenes, a clearance, and further tables switched off."""
    lines = [HELP_LINES[0], "# camopt keys machine lists all keys; camopt machine FILE --plot timing.svg draws it."]
    for place, own, more in STARTING_MACHINE:
        heading = table_heading(place)
        lines += ["", f"{'' if own else '#'}{heading}"] if place else [""]
        for key in MACHINE_TABLES[place].model_fields:
            if key in own or key in more:
                code = f"{'' if key in own else '#'}{key} = {_inline_toml_value((own | more)[key])}"
                record = key_record(MACHINE_TABLES[place], key)
                unit = "" if record.unit in ("", NO_UNIT) else f"{record.unit}: "
                lines.append(f"{code:<34}  # {unit}{record.sentence}")
    return "\n".join(_drop_repeated_comments(lines)) + "\n"


SQUARE = [[-10, 0], [10, 0], [10, 20], [-10, 20]]
STARTING_MACHINE: tuple[tuple[str, dict[str, Any], dict[str, Any]], ...] = (
    ("", {"name": "My machine", "rpm": 60}, {}),
    (
        "station",
        {"name": "pusher", "scene": "pusher-by-lever"},
        {"phase": 0, "outline": SQUARE, "direction": 90},
    ),
    ("station", {"name": "clamp", "scene": "clamp-by-wedge", "phase": 340}, {"ratio": 1}),
    (
        "station",
        {"name": "swing", "scene": "oscillating-roller", "phase": 200},
        {"outline": SQUARE, "pivot": [0, -80]},
    ),
    (
        "clear",
        {
            "name": "clamp is closed while the pusher is out",
            "between": ["clamp"],
            "along": [1],
            "at_least": 4,
            "angles": [97, 153],
        },
        {},
    ),
    ("body", {}, {"name": "rail", "outline": [[60, 0], [60, 40]], "outline_radius": 5}),
    ("flywheel", {}, {"fluctuation": 0.2}),
    ("motor", {}, {"catalogue": "motors.csv", "gear": 25, "inertia_ratio": 10}),
    ("search", {}, {"phase": {"clamp": [320, 360]}}),
)
"""Tables of a machine to start from: their place, their keys, and keys that are switched off."""


def _mechanism_and_tip(form: str | None, follower: str | None) -> tuple[Mechanism, Tip]:
    """The first mechanism with a form of cam and a follower, preferably with a roller; both may be None."""
    pairs = [
        pair
        for words, pair in PAIRINGS.items()
        if form in (None, words.split()[0]) and follower in (None, words.split()[1])
    ]
    if not pairs:
        named = " ".join(filter(None, (form, follower)))
        raise BadInput([Mistake("camopt", "follower", named, f"a mechanism; {suggest_names(named, PAIRINGS)}")])
    return next((pair for pair in pairs if pair[1].name == "roller"), pairs[0])


def _template_text(scene: Scene, data: Mapping[str, Any], comment_lines: list[str]) -> str:
    """A scene as text: its tables in order, each with further keys switched off."""
    more = further_key_examples_by_table(scene)
    lines = [*comment_lines, *HELP_LINES, f"name = {_inline_toml_value(data['name'])}"]
    for place, given in _tables_in_order(data):
        own = {key: value for key, value in given.items() if f"{place}.{key}" not in SCENE_TABLES}
        if own or place in more:
            lines += ["", *_table_lines(place, own, more.get(place, {}), scene)]
    return "\n".join(_drop_repeated_comments(lines)) + "\n"


def _tables_in_order(data: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The tables of a scene, and further tables it may have, by place in the order of a file."""
    yield "cam", data["cam"]
    yield "follower", data["follower"]
    yield "follower.dynamics", data["follower"].get("dynamics", {})
    yield "drive", data.get("drive", {})
    for kind in ("train", "motion", "profile"):
        for row in data.get(kind, []):
            yield kind, row
            yield from ((f"{kind}.through", each) for each in row.get("through", []))
    for name, law in data.get("laws", {}).items():
        yield f"laws.{name}", law
    for name in ("limits", "search", "synthesis", "materials", "part", "accuracy"):
        yield name, data.get(name, {})


HELP_LINES = [
    "# A line that begins with # and a key, or with #[, has no effect until you delete its #.",
    "# camopt keys lists all keys; camopt evaluate FILE --plot cam.svg shows the cam.",
]


def _table_lines(
    place: str, given_values: Mapping[str, Any], example_values: Mapping[str, Any], scene: Scene
) -> Iterator[str]:
    """The lines of a table."""
    known = "laws.NAME" if place.startswith("laws.") else place
    yield ("" if given_values else "#") + (table_heading(place) if place in TABLE_LISTS else f"[{place}]")
    for key in SCENE_TABLES[known].model_fields:
        if key in given_values or key in example_values:
            line = (
                f"{key} = {_inline_toml_value(given_values[key])}"
                if key in given_values
                else f"#{key} = {_inline_toml_value(example_values[key])}"
            )
            record = key_record(SCENE_TABLES[known], key)
            moved = scene.given_motion_is_angle if place.startswith("motion") else scene.tool_turns
            turns = scene.mechanism.motion.angular, moved, scene.straight_spring
            unit = record.unit_of(angular=is_key_of_angular_motion(f"{place}.{key}", *turns))
            yield f"{line:<26}  # {'' if unit in ('', NO_UNIT) else f'{unit}: '}{record.sentence}"


def _inline_toml_value(value: Any) -> str:
    """A value of TOML on one line."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_inline_toml_value(each)}' for key, each in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_inline_toml_value, value))}]"
    return tomli_w.dumps({"value": value}).removeprefix("value = ").rstrip()


def _drop_repeated_comments(lines: Iterable[str]) -> Iterator[str]:
    """Lines of TOML without comments that an earlier line has."""
    seen: set[str] = set()
    for line in lines:
        code, mark, comment = line.partition("  # ")
        yield line if comment not in seen or not mark else code.rstrip()
        seen.add(comment)
