"""Controls of the page: sizes, numbers, laws, angles, limits and tolerances of a scene."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities.unit_systems import from_shown_unit, to_shown_unit, unit_in_shown_system
from camopt.scene.choices import StepRange
from camopt.scene.numbers_with_units import numbers_with_units
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.variables import variables_of_scene
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES
from camopt.show.drawing.picture import round_down_to_1_2_5

Settings = Mapping[str, Any]
"""Values of controls by key: numbers and names of laws."""

LAW_CONTROLS = {"rise": "law_rise", "return": "law_return"}
"""The keys of the controls for the laws of all rises and of all returns."""
MOST_ANGLES = 24  # no sliders for the angles of more segments
RANGE_FACTORS = (3.0, 2.0, 1.5, 1.2)  # end of a slider over its value; the first that the scene allows
RANGE_GRID = 20  # ends of a slider are multiples of this part of its range
ZERO_RANGE = 10.0  # end of a slider whose value is 0
NEW_TOLERANCE = 0.05  # a third of the end of a slider, for a tolerance that is 0
LENGTH_TOLERANCES = ("profile", "bore_eccentricity")
"""Tolerances that are a distance, not the error of a number."""
SLIDER_STEPS = 250  # smallest number of steps of a slider
TURN_GROUP, OTHER_GROUP, TOLERANCE_GROUP = "Angles of the turn", "Loads and materials", "Tolerances"
FOLDED_GROUPS = (TURN_GROUP, OTHER_GROUP)
"""Groups of controls that are folded when the page opens."""


@dataclass(frozen=True)
class Control:
    """One control: a number with the range of its slider, or a choice of ``options``.

    ``unit`` is the unit in the scene. ``value``, ``low``, ``high``, ``step`` and ``options`` are in ``shown_unit``.
    """

    key: str
    group: str
    label: str
    unit: str
    value: float | str
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    options: tuple[float | str, ...] = ()

    @property
    def shown_unit(self) -> str:
        return unit_in_shown_system(self.unit)

    def value_in_control_unit(self, value: Any) -> Any:
        """A value of the scene, in the unit of the control."""
        return to_shown_unit(value, self.unit) if isinstance(value, float) else value

    def value_in_scene_unit(self, value: Any) -> Any:
        """A value of the control, in the unit of the scene."""
        return from_shown_unit(value, self.unit) if isinstance(value, float) else value


def controls_of(scene: Scene) -> list[Control]:
    """The controls of a scene, group by group."""
    problem = resolve(scene)
    limits = {each.key: each for each in problem.limits if each.set_by_scene and each.key.startswith("limits.")}
    angles = []
    for place, segment in enumerate(scene.motion, start=1):
        label = f"{place}. {segment.segment.replace('-', ' ')}"
        angles.append(Control(_segment_angle_key(place), TURN_GROUP, label, "deg", segment.angle, 0.0, 360.0, 1.0))
    return [
        *_size_controls(scene),
        *_law_controls(scene, problem),
        *(
            _number_control(scene, key, "Limits", each.quantity.unit if each.quantity else "", each.bound, None)
            for key, each in limits.items()
        ),
        *_tolerance_controls(scene),
        *(angles if 1 < len(angles) <= MOST_ANGLES else []),
        *(
            _number_control(scene, key, OTHER_GROUP, unit, value, scene.search.numbers.get(key))
            for key, value, unit in numbers_with_units(scene)
            if isinstance(value, float) and key != "cam.rpm"
        ),
    ]


def control_values(scene: Scene, keys: Mapping[str, Any] | list[str]) -> dict[str, Any]:
    """The values of controls for a scene, in units of the scene."""
    values: dict[str, Any] = scene.numbers(
        [key for key in keys if not _is_motion_key(key)]
    ) | _symmetric_tolerance_widths(scene)
    for kind, key in LAW_CONTROLS.items():
        laws = {segment.law for segment in scene.motion if segment.segment == kind}
        values[key] = laws.pop() if len(laws) == 1 else ""
    values |= {_segment_angle_key(place): segment.angle for place, segment in enumerate(scene.motion, start=1)}
    return {key: values[key] for key in keys}


def scene_with_settings(scene: Scene, initial: Settings, values: Settings, moved_key: str = "") -> Scene:
    """The scene with the values of its controls; ``initial`` are those of the scene itself.

    ``moved_key`` is the key of the control that moved last. If it is an angle, the other angles are scaled, so that
    the turn stays 360°.

    Raises
    ------
    BadInput
        For keys that are not controls of the scene, and for values that the scene refuses.
    """
    unknown = [
        *(key for key in values if key not in initial),
        *([moved_key] if moved_key and moved_key not in initial else []),
    ]
    if unknown:
        why = {key: f"not a control; {suggest_names(key, initial)}" for key in unknown}
        raise BadInput([Mistake("page", key, None, text, bare=True) for key, text in why.items()])
    changes = {key: value for key, value in values.items() if value != initial[key]}
    plain = {
        key: _scene_entry_of_control(scene, key, value) for key, value in changes.items() if not _is_motion_key(key)
    }
    if len(plain) < len(changes):
        plain["motion"] = _changed_segments(scene, {**initial, **values}, moved_key)
    return scene.replace(**plain) if plain else scene


def _symmetric_tolerance_widths(scene: Scene) -> dict[str, float]:
    """Half-widths of the symmetric tolerances, by key; without ISO classes and measured values."""
    tolerances = scene.tolerances
    even = {key: each for key, each in tolerances.number_and_angle_tolerances.items() if each.plus == each.minus}
    widths = {key: each.plus for key, each in even.items() if each.iso is None and each.values is None}
    widths |= {key: value for key in LENGTH_TOLERANCES if (value := getattr(tolerances, key)) is not None}
    return {f"tolerances.{key}": value for key, value in widths.items()}


def _scene_entry_of_control(scene: Scene, key: str, value: Any) -> Any:
    """The scene's entry for a control: its value, or for a tolerance with further keys all of them."""
    tolerance = scene.tolerances.number_and_angle_tolerances.get(key.removeprefix("tolerances."))
    more = tolerance.model_dump(exclude_defaults=True, exclude={"plus", "minus"}) if tolerance else {}
    return {**more, "plus": value, "minus": value} if more and key.startswith("tolerances.") else value


def _tolerance_controls(scene: Scene) -> Iterator[Control]:
    """Controls of the symmetric tolerances, from 0 to three times the width, or as far as the scene allows."""
    units = {f"tolerances.{each.key}": each.unit for each in variables_of_scene(scene)}
    units |= {f"tolerances.{key}": "deg" for key in ANGLE_TOLERANCES}
    for key, value in _symmetric_tolerance_widths(scene).items():
        unit, label = units.get(key, "mm"), key.removeprefix("tolerances.").rpartition(".")[2].replace("_", " ")
        width = to_shown_unit(value, unit) or NEW_TOLERANCE
        ends = (width * factor for factor in RANGE_FACTORS)
        high = next((each for each in ends if _is_allowed(scene, key, from_shown_unit(each, unit))), width)
        step = round_down_to_1_2_5(high / SLIDER_STEPS)
        least = step if key.removeprefix("tolerances.") in LENGTH_TOLERANCES else 0.0
        yield Control(key, TOLERANCE_GROUP, f"± {label}", unit, to_shown_unit(value, unit), least, high, step)


def _changed_segments(scene: Scene, values: Settings, moved_key: str) -> list[dict[str, Any]]:
    """The segments of the motion with the laws and angles of the controls."""
    rows: list[dict[str, Any]] = [dict(row) for row in scene.to_dict()["motion"]]
    for place, row in enumerate(rows, start=1):
        row["angle"] = values.get(_segment_angle_key(place), row["angle"])
        if law := values.get(LAW_CONTROLS.get(row["segment"], ""), ""):
            row["law"] = law
    others = [row for place, row in enumerate(rows, start=1) if _segment_angle_key(place) != moved_key]
    if len(others) < len(rows) and all(isinstance(row["angle"], float) for row in rows):
        rest, total = 360.0 - values[moved_key], sum(row["angle"] for row in others)
        for row in others if total > 0.0 and 0.0 <= rest <= 360.0 else ():
            row["angle"] *= rest / total
    return rows


def _segment_angle_key(segment_number: int) -> str:
    """Key of the angle of a segment, counted from 1, as in messages."""
    return f"motion.{segment_number}.angle"


def _is_motion_key(key: str) -> bool:
    return key.startswith("motion.") or key in LAW_CONTROLS.values()


def _size_controls(scene: Scene) -> Iterator[Control]:
    """Controls of the sizes and the speed."""
    for each in variables_of_scene(scene):
        (value,) = scene.numbers([each.key]).values()
        if value is None or (scene.profile and each.key == "cam.base_radius"):  # derived from the profile
            continue
        if each.is_size:
            yield _number_control(scene, each.key, "Sizes", each.unit, value, each.choice)
        elif each.key == "cam.rpm":
            yield _number_control(scene, each.key, "Speed", "rev/min", value, each.choice)


def _law_controls(scene: Scene, problem: Problem) -> Iterator[Control]:
    """Controls of the laws of rises and returns. Laws given as positions are for moves, and left out."""
    tables = scene.laws
    laws = tuple(name for name in problem.laws if name not in tables or tables[name].positions is None)
    values = control_values(scene, list(LAW_CONTROLS.values()))
    for kind, key in LAW_CONTROLS.items():
        if any(segment.segment == kind for segment in scene.motion):
            options = laws if values[key] else ("", *laws)  # several laws stay as they are until one is chosen
            yield Control(key, "Laws", f"law of the {kind}s", "", values[key], options=options)


def _number_control(scene: Scene, key: str, group: str, unit: str, value: float, search_values: Any) -> Control:
    label = key.rpartition(".")[2].replace("_", " ")
    here = to_shown_unit(value, unit)
    if isinstance(search_values, tuple):
        options = tuple(to_shown_unit(each, unit) for each in sorted({*search_values, value}))
        return Control(key, group, label, unit, here, options=options)
    ranged = isinstance(search_values, StepRange)
    ends = (
        (to_shown_unit(search_values.start, unit), to_shown_unit(search_values.stop, unit))
        if ranged
        else _slider_range(scene, key, here, unit)
    )
    low, high = min(ends[0], here), max(ends[1], here)
    step = round_down_to_1_2_5((high - low) / SLIDER_STEPS) if high > low else 1.0
    if ranged and search_values.step:
        step = to_shown_unit(search_values.step, unit)
    return Control(key, group, label, unit, here, low, high, step)


def _slider_range(scene: Scene, key: str, value: float, unit: str) -> tuple[float, float]:
    """Ends of the slider of a shown number, as far as the scene allows.

    From a third of the number to three times; from minus to plus if the scene allows a negative number.
    """
    both = value <= 0.0 or _is_allowed(scene, key, -from_shown_unit(value, unit))
    width = 2.0 * abs(value) or ZERO_RANGE
    grid = round_down_to_1_2_5(width / RANGE_GRID)
    lows = [ceil(x / grid) * grid for x in ([-width] if both else [value / factor for factor in RANGE_FACTORS])]
    highs = [floor(x / grid) * grid for x in ([width] if both else [value * factor for factor in RANGE_FACTORS])]
    low, high = (
        next((x for x in xs if _is_allowed(scene, key, from_shown_unit(x, unit))), value) for xs in (lows, highs)
    )
    return low, high


def _is_allowed(scene: Scene, key: str, value: float) -> bool:
    try:
        scene.replace(**{key: value})
    except BadInput:
        return False
    return True
