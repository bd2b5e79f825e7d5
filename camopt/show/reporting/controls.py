"""What can be moved of a scene: sizes, numbers, laws, angles, limits and tolerances, each a control of the page."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities.unit_systems import from_shown_unit, shown_unit, to_shown_unit
from camopt.scene.choices import StepRange
from camopt.scene.numbers_with_units import numbers_with_units
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.variables import variables_of
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES
from camopt.show.drawing.picture import round_length

Settings = Mapping[str, Any]
"""Numbers and names of laws, by the keys of controls."""

LAW_CONTROLS = {"rise": "law_rise", "return": "law_return"}
"""The keys of the controls for the laws of all rises and of all returns."""
MOST_ANGLES = 24  # segments that have a slider each
RANGE_FACTORS = (3.0, 2.0, 1.5, 1.2)  # of a number, to which its slider may go if the scene allows
RANGE_GRID = 20  # parts of a range, on which its ends lie
ZERO_RANGE = 10.0  # how far the slider of a number goes that is 0
NEW_TOLERANCE = 0.05  # and a third of that of a tolerance
LENGTH_TOLERANCES = ("profile", "bore_eccentricity")
"""Tolerances that are a distance, and no number that is off."""
SLIDER_STEPS = 250  # of a slider, at least
TURN_GROUP, OTHER_GROUP, TOLERANCE_GROUP = "Angles of the turn", "Loads and materials", "Tolerances"
FOLDED_GROUPS = (TURN_GROUP, OTHER_GROUP)
"""Groups of controls that a page opens folded."""


@dataclass(frozen=True)
class Control:
    """One control: a number with the range of its slider, or a choice from some ``options``.

    ``unit`` is that of the scene; the numbers are as they are shown, in ``shown_unit``.
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
        return shown_unit(self.unit)

    def control_value(self, value: Any) -> Any:
        """A value of the scene as the control shows it."""
        return to_shown_unit(value, self.unit) if isinstance(value, float) else value

    def read(self, value: Any) -> Any:
        """The other way round."""
        return from_shown_unit(value, self.unit) if isinstance(value, float) else value


def controls_of(scene: Scene) -> list[Control]:
    """The controls of a scene, group by group."""
    problem = resolve(scene)
    limits, tolerances = _limit_controls(scene, problem), _tolerance_controls(scene)
    return [
        *_size_controls(scene),
        *_law_controls(scene, problem),
        *limits,
        *tolerances,
        *_angle_controls(scene),
        *_load_controls(scene),
    ]


def control_values(scene: Scene, keys: Mapping[str, Any] | list[str]) -> dict[str, Any]:
    """What controls of these keys show of a scene."""
    found: dict[str, Any] = scene.numbers([key for key in keys if not _is_motion_key(key)]) | _tolerance_widths(
        scene
    )
    for kind, key in LAW_CONTROLS.items():
        laws = {segment.law for segment in scene.motion if segment.segment == kind}
        found[key] = laws.pop() if len(laws) == 1 else ""
    found |= {_angle_key(place): segment.angle for place, segment in enumerate(scene.motion, start=1)}
    return {key: found[key] for key in keys}


def scene_of_settings(scene: Scene, own: Settings, values: Settings, moved: str = "") -> Scene:
    """The scene as controls have it whose values of its own are ``own``.

    Of the angles, the others make room for the one that was moved last.

    Raises
    ------
    BadInput
        For keys that are no controls of the scene, and whatever else the scene refuses.
    """
    unknown = [*(key for key in values if key not in own), *([moved] if moved and moved not in own else [])]
    if unknown:
        why = {key: f"no control; {suggest_names(key, own)}" for key in unknown}
        raise BadInput([Mistake("page", key, None, text, bare=True) for key, text in why.items()])
    changes = {key: value for key, value in values.items() if value != own[key]}
    plain = {key: _whole_tolerance(scene, key, each) for key, each in changes.items() if not _is_motion_key(key)}
    if len(plain) < len(changes):
        plain["motion"] = _changed_segments(scene, {**own, **values}, moved)
    return scene.replace(**plain) if plain else scene


def _tolerance_widths(scene: Scene) -> dict[str, float]:
    """How wide the tolerances are, ±, by key; not of classes, of measured parts, and of one side."""
    given = scene.tolerances
    even = {key: each for key, each in given.number_and_angle_tolerances.items() if each.plus == each.minus}
    found = {key: each.plus for key, each in even.items() if each.iso is None and not each.has_measured_values}
    found |= {key: value for key in LENGTH_TOLERANCES if (value := getattr(given, key)) is not None}
    return {f"tolerances.{key}": value for key, value in found.items()}


def _whole_tolerance(scene: Scene, key: str, value: Any) -> Any:
    """A value of a control; of a tolerance with all else that the scene says of it."""
    own = scene.tolerances.number_and_angle_tolerances.get(key.removeprefix("tolerances."))
    more = own.model_dump(exclude_defaults=True, exclude={"plus", "minus"}) if own else {}
    return {**more, "plus": value, "minus": value} if more and key.startswith("tolerances.") else value


def _tolerance_controls(scene: Scene) -> Iterator[Control]:
    """The tolerances that are one number, from nothing to three times as wide, or as far as the scene allows."""
    units = {f"tolerances.{each.key}": each.unit for each in variables_of(scene)}
    units |= {f"tolerances.{key}": "deg" for key in ANGLE_TOLERANCES}
    for key, value in _tolerance_widths(scene).items():
        unit, label = units.get(key, "mm"), key.removeprefix("tolerances.").rpartition(".")[2].replace("_", " ")
        width = to_shown_unit(value, unit) or NEW_TOLERANCE
        wide = (width * reach for reach in RANGE_FACTORS)
        high = next((each for each in wide if _is_allowed(scene, key, from_shown_unit(each, unit))), width)
        step = round_length(high / SLIDER_STEPS)
        least = step if key.removeprefix("tolerances.") in LENGTH_TOLERANCES else 0.0
        yield Control(key, TOLERANCE_GROUP, f"± {label}", unit, to_shown_unit(value, unit), least, high, step)


def _changed_segments(scene: Scene, values: Settings, moved: str) -> list[dict[str, Any]]:
    """The segments with other laws and angles."""
    rows: list[dict[str, Any]] = [dict(row) for row in scene.to_dict()["motion"]]
    for place, row in enumerate(rows, start=1):
        row["angle"] = values.get(_angle_key(place), row["angle"])
        if law := values.get(LAW_CONTROLS.get(row["segment"], ""), ""):
            row["law"] = law
    others = [row for place, row in enumerate(rows, start=1) if _angle_key(place) != moved]
    if len(others) < len(rows) and all(isinstance(row["angle"], float) for row in rows):
        rest, taken = 360.0 - values[moved], sum(row["angle"] for row in others)
        for row in others if taken > 0.0 and 0.0 <= rest <= 360.0 else ():
            row["angle"] *= rest / taken
    return rows


def _angle_key(place: int) -> str:
    """The key of the control for the angle of a segment, counted from 1, as messages name it."""
    return f"motion.{place}.angle"


def _is_motion_key(key: str) -> bool:
    return key.startswith("motion.") or key in LAW_CONTROLS.values()


def _size_controls(scene: Scene) -> Iterator[Control]:
    """The sizes, and the speed."""
    for each in variables_of(scene):
        (value,) = scene.numbers([each.key]).values()
        if value is None or (scene.profile and each.key == "cam.base_radius"):  # which follows from the profile
            continue
        if each.is_size:
            yield _number_control(scene, each.key, "Sizes", each.unit, value, each.choice)
        elif each.key == "cam.rpm":
            yield _number_control(scene, each.key, "Speed", "rev/min", value, each.choice)


def _load_controls(scene: Scene) -> Iterator[Control]:
    """The other numbers that the scene gives, such as masses and springs."""
    for key, value, unit in numbers_with_units(scene):
        if isinstance(value, float) and key != "cam.rpm":
            yield _number_control(scene, key, OTHER_GROUP, unit, value, scene.search.numbers.get(key))


def _limit_controls(scene: Scene, problem: Problem) -> Iterator[Control]:
    """The bounds that the scene sets."""
    bounds = {
        limit.key: limit for limit in problem.limits if limit.set_by_scene and limit.key.startswith("limits.")
    }
    for key, limit in bounds.items():
        unit = limit.quantity.unit if limit.quantity else ""
        yield _number_control(scene, key, "Limits", unit, limit.bound, None)


def _law_controls(scene: Scene, problem: Problem) -> Iterator[Control]:
    """The laws of rises and returns; those given as positions are for moves."""
    own = scene.laws
    laws = tuple(name for name in problem.laws if name not in own or own[name].positions is None)
    values = control_values(scene, list(LAW_CONTROLS.values()))
    for kind, key in LAW_CONTROLS.items():
        if any(segment.segment == kind for segment in scene.motion):
            options = laws if values[key] else ("", *laws)  # several laws stay as they are until one is chosen
            yield Control(key, "Laws", f"law of the {kind}s", "", values[key], options=options)


def _angle_controls(scene: Scene) -> Iterator[Control]:
    if 1 < len(scene.motion) <= MOST_ANGLES:
        for place, segment in enumerate(scene.motion, start=1):
            label = f"{place}. {segment.segment.replace('-', ' ')}"
            yield Control(_angle_key(place), TURN_GROUP, label, "deg", segment.angle, 0.0, 360.0, 1.0)


def _number_control(scene: Scene, key: str, group: str, unit: str, value: float, chosen: Any) -> Control:
    label = key.rpartition(".")[2].replace("_", " ")
    here = to_shown_unit(value, unit)
    if isinstance(chosen, tuple):
        options = tuple(to_shown_unit(each, unit) for each in sorted({*chosen, value}))
        return Control(key, group, label, unit, here, options=options)
    ranged = isinstance(chosen, StepRange)
    ends = (
        (to_shown_unit(chosen.start, unit), to_shown_unit(chosen.stop, unit))
        if ranged
        else _slider_range(scene, key, here, unit)
    )
    low, high = min(ends[0], here), max(ends[1], here)
    step = round_length((high - low) / SLIDER_STEPS) if high > low else 1.0
    if ranged and chosen.step:
        step = to_shown_unit(chosen.step, unit)
    return Control(key, group, label, unit, here, low, high, step)


def _slider_range(scene: Scene, key: str, value: float, unit: str) -> tuple[float, float]:
    """A range about a number as it is shown, as far as the scene allows: a third to three times, or about 0."""
    both = value <= 0.0 or _is_allowed(scene, key, -from_shown_unit(value, unit))
    width = 2.0 * abs(value) or ZERO_RANGE
    grid = round_length(width / RANGE_GRID)
    lows = [ceil(x / grid) * grid for x in ([-width] if both else [value / share for share in RANGE_FACTORS])]
    highs = [floor(x / grid) * grid for x in ([width] if both else [value * share for share in RANGE_FACTORS])]
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
