"""The train between follower and tool: the keys of its stages, and their checks with the motion."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import degrees, radians
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from camopt.core.quantities.key import Key
from camopt.core.quantities.stage_numbers import STAGE_NUMBERS
from camopt.model.mechanisms.elements import MOTIONS
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.profile import ProfileFault
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import start_position
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.carried_load import CarriedLoad
from camopt.model.trains.link import formula_value_at_end
from camopt.model.trains.train import StageFault, Train, assemble_train, assemble_train_with_arrays
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.load import split_constant_and_changing_load
from camopt.scene.profile import profile_programme_if_known
from camopt.scene.tables import (
    GivenLoad,
    SceneNumber,
    Switch,
    TableOfRecords,
    number_keys_with_types,
    with_optional_keys,
)
from camopt.scene.turn import segments_and_programme_of_scene

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

NEAR_DEAD_POINT = 1e-6  # share of a dead point's distance from the start position; a tool nearer to it is at it
MOST_STAGES = 20
DEAD_POINT_SAMPLES = 3601  # cam angles of the turn at which a tool beyond a dead point is looked for
StageAngle = Annotated[SceneNumber, Field(ge=-360, le=360)]
STAGE_ANGLES = ("angle", "input_angle", "output_angle", "guide")
NUMBERS_OF_STAGE = number_keys_with_types(STAGE_NUMBERS, load=GivenLoad, **dict.fromkeys(STAGE_ANGLES, StageAngle))
CROSSED_KEY = {"crossed": (Switch, Key("Whether the coupler of a four-bar linkage crosses its ground"))}
KEYS_BEFORE_CROSSED = ("crank", "coupler", "rocker", "ground", "offset", "angle")
STAGE_KEYS = {**{key: NUMBERS_OF_STAGE[key] for key in KEYS_BEFORE_CROSSED}, **CROSSED_KEY, **NUMBERS_OF_STAGE}
"""The keys of a stage, in order."""


@with_optional_keys(STAGE_KEYS)
class TrainStage(TableOfRecords):
    """One stage of the train, the linkage between the follower and the tool; list them from the follower on.

    With a train, ``[[motion]]`` is the motion of the tool. With ``motion_at = "follower"`` it is the motion of the
    follower, and with a ``[[profile]]`` the profile gives that motion; camopt then computes the motion of the tool.
    Velocity, acceleration, jerk, lift change, lash and vibration, and the limits on them, apply to the tool.
    Pressure angle, curvature and ``[follower.dynamics]`` apply to the follower.

    The input of a stage is a length or an angle, the output of the stage before it. The angles of a stage hold in
    the start position, where the tool is at 0: at the start of the turn or, if the motion has positions, at
    position 0.

    - ``rocker``: two arms, with rollers or pads on faces square to their motions.
    - ``bell-crank``: a rocker whose second arm, the crank, moves a slide through a coupler.
    - ``slider-crank``: a crank that moves a slide through a coupler; if its input is a length, the slide moves the
      crank.
    - ``four-bar``: a crank that moves a rocker through a coupler.
    - ``ratio``: levers, gears or belts; or, with ``radius``, a pinion or drum between angle and length. Below 0 it
      reverses the motion.
    - ``incline``: a wedge.

    A rocker or bell crank has an ``input_arm`` if its input is a length; an oscillating follower is itself that
    arm. Angles grow as the follower moves outward; a slide moves away from the pivot of its crank.

    Masses, springs and forces of a stage act on its output member, and on the follower by virtual work. A force
    above 0 acts against the displacement of that member.
    """

    stage: Annotated[Literal[tuple(TRAIN_STAGES)], Key("Kind of stage")]  # type: ignore[valid-type]


CARRIED_KEYS = ("mass", "inertia", "arm_inertia", "spring_rate", "preload", "load", "gravity", "friction_force")
"""Keys of the masses of a stage, and of the forces on it."""


def keys_of_stage_kind(name: str) -> tuple[str, ...]:
    """The keys that a kind of stage may have; for an unknown kind, the keys of all stages."""
    stage = TRAIN_STAGES.get(name)
    return (*stage.needs, *stage.others, *CARRIED_KEYS) if stage else (*TrainStage.model_fields,)


def build_train(rows: Sequence[TrainStage], *, angular: bool) -> Train | None:
    """The train of a scene, None without stages; ``angular`` says whether the follower turns.

    Raises
    ------
    StageFault
        For the first stage that cannot be assembled, or has a mass or force that it cannot have.
    """
    return _train_with_stage_masses_and_forces(assemble_train, rows, {}, angular) if rows else None


def build_trains(rows: Sequence[TrainStage], numbers: Mapping[str, Any], *, angular: bool) -> Train:
    """The trains with other numbers, by key such as ``train.1.crank``: arrays, or ranges with slopes."""
    return _train_with_stage_masses_and_forces(assemble_train_with_arrays, rows, numbers, angular)


def _train_with_stage_masses_and_forces(
    assemble: Callable[..., Train], rows: Sequence[TrainStage], numbers: Mapping[str, Any], angular: bool
) -> Train:
    """The train of some stages, with their masses and forces; ``numbers`` replace values, by key of the scene."""
    stages = [row.model_dump(exclude={"load"}, exclude_none=True) | {"load": row.load} for row in rows]
    for key, value in numbers.items():
        _, number, name = key.split(".")
        stages[int(number) - 1][name] = value
    not_of_links = ("stage", *CARRIED_KEYS)
    links = [(each["stage"], {key: v for key, v in each.items() if key not in not_of_links}) for each in stages]
    train = assemble(links, angular=angular)
    return replace(train, carried=tuple(_masses_and_forces_of_stages(stages, train)))


def _masses_and_forces_of_stages(stages: Sequence[Mapping[str, Any]], train: Train) -> Iterator[CarriedLoad]:
    """The mass of each stage, and the constant forces on it."""
    for number, stage in enumerate(stages, start=1):
        joint, turns, unit = _output_joint_turns_and_unit(train, number)
        if ("mass" if turns else "inertia") in stage:
            motion, body = ("turns", "an inertia, not a mass") if turns else ("slides", "a mass, not an inertia")
            raise StageFault(number, f"its output member {motion}: give it {body}")
        if "gravity" in stage and "mass" not in stage:
            raise StageFault(number, "gravity acts on a mass, which is missing")
        mass = stage.get("inertia", 0.0) * 1e3 if turns else stage.get("mass", 0.0) * 1e-3
        constant, changing = split_constant_and_changing_load(stage["load"], unit)
        force = constant + stage.get("preload", 0.0) * unit + mass * 1e3 * stage.get("gravity", 0.0)
        stiffness, friction = (stage.get(name, 0.0) * unit for name in ("spring_rate", "friction_force"))
        if changing or any(not isinstance(each, float) or each for each in (mass, stiffness, force, friction)):
            yield CarriedLoad(joint, mass, stiffness, force, friction)
        if "arm_inertia" in stage:
            if train.stages.count(number) == 1:
                raise StageFault(number, "it has no arm of its own: arm_inertia goes with an input_arm")
            yield CarriedLoad(joint - 1, stage["arm_inertia"] * 1e3)


def _output_joint_turns_and_unit(train: Train, stage_number: int) -> tuple[int, bool, float]:
    """The output joint of a stage, whether it turns, and the unit of forces there in N (N·mm)."""
    joint = max(k for k, stage in enumerate(train.stages, start=1) if stage == stage_number)
    turns = train.links[joint - 1].driver_and_driven_angular[1]
    return joint, turns, 1e3 if turns else 1.0


def follower_load_with_train(
    rows: Sequence[TrainStage], train: Train | None, load: ExternalLoad | None
) -> ExternalLoad | TrainLoad | None:
    """Load on the follower in addition to its dynamics: its changing load, and the loads of the train's stages."""
    if train is None:
        return load
    loads = [] if load is None else [(0, load)]
    for number, row in enumerate(rows, start=1):
        joint, _, unit = _output_joint_turns_and_unit(train, number)
        _, changing = split_constant_and_changing_load(row.load, unit)
        loads += [] if changing is None else [(joint, changing)]
    return TrainLoad(train, tuple(loads)) if train.carried else load


def tool_turns(rows: Sequence[Mapping[str, Any]], follower_turns: bool) -> bool:
    """Whether the tool turns; ``follower_turns`` says whether the follower does."""
    for row in rows:
        if (name := row.get("stage")) in TRAIN_STAGES:
            follower_turns = TRAIN_STAGES[str(name)].turns(
                {key: each for key, each in row.items() if each is not None}, follower_turns
            )
    return follower_turns


def check_train(scene: "Scene") -> Iterator[Fault]:
    """Every fault of a train: in its stages, in ``[search]``, and a tool beyond a dead point."""
    for number, keys in scene.search.train.items():
        if not (number.isdecimal() and 0 < int(number) <= len(scene.train)):
            yield f"search.train.{number}", None, f"the train of the scene has {stage_count_text(scene)}"
            continue
        stage = scene.train[int(number) - 1]
        for key in keys if stage.stage in TRAIN_STAGES else ():
            where = f"search.train.{number}.{key}"
            if key not in keys_of_stage_kind(stage.stage):
                yield where, VALUE_IN_SCENE, f"{TRAIN_STAGES[stage.stage].words} has no {key}"
            elif isinstance(getattr(stage, key), tuple):
                why = f"train.{number}.{key} changes over the turn; a single number cannot replace it"
                yield where, VALUE_IN_SCENE, why
    try:
        train = train_without_loads(scene)
    except StageFault as fault:
        yield f"train.{fault.number}", None, str(fault)
        return
    if train is not None:
        yield from _check_dead_points(scene, train)


def stage_count_text(scene: "Scene") -> str:
    """The number of stages of the train, in words."""
    return "1 stage" if len(scene.train) == 1 else f"{len(scene.train) or 'no'} stages"


def train_without_loads(scene: "Scene") -> Train | None:
    """The train of a scene without loads, which ``scene.load`` checks; None if a value or the follower is wrong."""
    if scene.follower.motion not in MOTIONS or scene.has_refused_value("train", all_keys=True):
        return None
    rows = [row.model_copy(update={"load": None}) for row in scene.train]
    return build_train(rows, angular=MOTIONS[scene.follower.motion].angular)


class GivenTurn(NamedTuple):
    """The motion that a scene gives, of its tool or its follower, as positions from the start of the train."""

    programme: Programme
    low: float
    """Lowest position [mm or rad]."""
    high: float
    """Highest position [mm or rad]."""
    unit: float
    """Unit of the programme [mm or rad]."""


def _train_from_given_end(scene: "Scene", train: Train) -> Train:
    """The train whose tool end has the given motion: reversed if the motion is the follower's."""
    return train.reversed_train if scene.given_at_follower else train


def _given_motion_at_tool_end(scene: "Scene", train: Train) -> GivenTurn | None:
    """The given motion at the tool end of a train; None where it is not known."""
    if scene.profile:
        try:
            on_profile = profile_programme_if_known(scene)
        except ProfileFault:  # check_profile reports it
            return None
        if on_profile is None:
            return None
        low = -on_profile.strokes[0].low
        return GivenTurn(on_profile, low, low + on_profile.lift, 1.0)
    if (found := segments_and_programme_of_scene(scene)) is None:
        return None
    given, programme = found
    unit = radians(1.0) if train.angular else 1.0
    low = (start_position(given) - programme.start) * unit
    return GivenTurn(programme, low, low + programme.lift * unit, unit)


def _check_dead_points(scene: "Scene", train: Train) -> Iterator[Fault]:
    """Faults where the tool, or a follower with a given motion, reaches a dead point of the train."""
    who, train = "follower" if scene.given_at_follower else "tool", _train_from_given_end(scene, train)
    turn = _given_motion_at_tool_end(scene, train)
    unit, word = (radians(1.0), "deg") if train.angular else (1.0, "mm")
    for side, end in zip((-1.0, 1.0), train.tool_travel_ends, strict=True) if turn else ():
        assert turn is not None
        farthest, limit = turn.high if side > 0.0 else turn.low, end.at
        if side * farthest >= side * limit - NEAR_DEAD_POINT * abs(limit):
            goes = f"the {who} has to go to {farthest / unit:.6g} {word}"
            place = f"{limit / unit:.6g} {word} (cam angle {_cam_angle_at_dead_point(turn, side, limit):.4g} deg)"
            yield f"train.{end.stage}", None, f"{goes}, but a dead point is at {place}: {end.why} there"


def _cam_angle_at_dead_point(turn: GivenTurn, side: float, limit: float) -> float:
    """Cam angle at which a motion reaches a limit, or comes nearest to it [deg]."""
    angles = np.linspace(0.0, 2 * np.pi, DEAD_POINT_SAMPLES)
    ahead = side * (turn.low + turn.programme.motion_at(angles)[0] * turn.unit - limit)
    over = np.flatnonzero(ahead >= 0.0)
    return float(np.degrees(angles[over[0] if over.size else int(ahead.argmax())]))


class Lifts(NamedTuple):
    """Largest displacement above the lowest, of a tool and its follower [mm or deg]; None where unknown."""

    tool: float | None
    follower: float | None


def lifts_through_train(scene: "Scene", given_lift: float | None) -> Lifts:
    """The lifts of tool and follower of a scene with a train; ``given_lift`` is the lift of ``[[motion]]``."""
    other, train = None, None if any(check_train(scene)) else train_without_loads(scene)
    if train is not None and (turn := _given_motion_at_tool_end(scene, out := _train_from_given_end(scene, train))):
        low, high = sorted(
            formula_value_at_end(out.follower_displacement, level) for level in (turn.low, turn.high)
        )
        other = (high - low) * (degrees(1.0) if out.links[0].driver_and_driven_angular[0] else 1.0)
    return Lifts(other, given_lift) if scene.given_at_follower else Lifts(given_lift, other)
