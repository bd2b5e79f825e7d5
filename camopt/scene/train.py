"""The train between follower and tool: the keys of its stages, and their checks with the motion."""

from collections.abc import Iterator, Mapping, Sequence
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
from camopt.model.trains.link import value_at_end
from camopt.model.trains.train import StageFault, Train, assemble_train, assemble_trains
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.load import split_load
from camopt.scene.mapping import tables_in
from camopt.scene.profile import known_programme
from camopt.scene.tables import (
    GivenLoad,
    SceneNumber,
    Switch,
    TableOfRecords,
    number_keys,
    with_keys,
)
from camopt.scene.turn import turn_of_scene

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

NEAR_DEAD_POINT = 1e-6  # of its distance from the start position: a tool so near to a dead point is at it
MOST_STAGES = 20
DEAD_POINT_SAMPLES = 3601  # cam angles of the turn at which a tool beyond a dead point is looked for
StageAngle = Annotated[SceneNumber, Field(ge=-360, le=360)]
STAGE_ANGLES = ("angle", "input_angle", "output_angle", "guide")
NUMBERS_OF_STAGE = number_keys(STAGE_NUMBERS, load=GivenLoad, **dict.fromkeys(STAGE_ANGLES, StageAngle))
CROSSED_KEY = {"crossed": (Switch, Key("Whether coupler and ground of a four-bar linkage cross"))}
KEYS_BEFORE_CROSSED = ("crank", "coupler", "rocker", "ground", "offset", "angle")
STAGE_KEYS = {**{key: NUMBERS_OF_STAGE[key] for key in KEYS_BEFORE_CROSSED}, **CROSSED_KEY, **NUMBERS_OF_STAGE}
"""The keys of a stage, in order."""


@with_keys(STAGE_KEYS)
class TrainStage(TableOfRecords):
    """One stage of the train between the follower and the tool, in order from the follower.

    With a train, ``[[motion]]`` is that of the tool (or with ``motion_at = "follower"`` of the follower, and the
    tool's is what follows), and so are velocity, acceleration, jerk, lift change, lash and
    vibration, and limits on them; pressure angle, curvature and ``[follower.dynamics]`` are those of the follower.
    Each stage takes a length or an angle from what is before it, and moves the next. Its angles are those of the
    start position, in which the tool is at 0: where the turn starts, or at the position 0 of a motion that gives
    positions. With a ``[[profile]]`` the cam is known, and the motion of the tool is what follows.

    - A ``rocker`` has two arms, with rollers or pads on faces square to the motions that they take and give.
    - A ``bell-crank`` is a rocker whose second arm, the crank, moves a slide by a coupler.
    - A ``slider-crank`` is a crank that moves a slide by a coupler; where what comes to it is a length, the slide
      moves the crank.
    - A ``four-bar`` is a crank that moves a rocker by a coupler.
    - A ``ratio`` is that of levers, gears or belts, or has the ``radius`` of a pinion or drum between angle and
      length; below 0 it turns the motion round.
    - An ``incline`` is a wedge.

    Rocker and bell crank have an ``input_arm`` where what comes to them is a length; an oscillating follower is
    that arm itself. Angles grow as the follower goes outward; a slide goes away from the pivot of its crank.

    Masses, springs and forces of a stage act on what it moves, and come to the follower by virtual work. A force is
    above 0 if it is against the displacement that the stage gives.
    """

    stage: Annotated[Literal[tuple(TRAIN_STAGES)], Key("What the stage is")]  # type: ignore[valid-type]


CARRIED_KEYS = ("mass", "inertia", "arm_inertia", "spring_rate", "preload", "load", "gravity", "friction_force")
"""Keys of what a stage carries, and of what acts on it."""


def keys_of_stage(name: str) -> tuple[str, ...]:
    """The keys that a stage of some name may have; of a name that is none, all keys of stages."""
    stage = TRAIN_STAGES.get(name)
    return (*stage.needs, *stage.others, *CARRIED_KEYS) if stage else (*TrainStage.model_fields,)


def build_train(rows: Sequence[TrainStage], *, angular: bool) -> Train | None:
    """The train of a scene, from a follower whose motion is an angle or not; None where there is none.

    Raises
    ------
    StageFault
        For the first stage that cannot be put together, or carries what it cannot.
    """
    if not rows:
        return None
    stages = _stage_values(rows, {})
    return _with_carried_parts(assemble_train([_link_keys(each) for each in stages], angular=angular), stages)


def build_trains(rows: Sequence[TrainStage], numbers: Mapping[str, Any], *, angular: bool) -> Train:
    """The trains of a scene with other numbers, by key as ``train.1.crank``: arrays, or ranges with slopes."""
    stages = _stage_values(rows, numbers)
    return _with_carried_parts(assemble_trains([_link_keys(each) for each in stages], angular=angular), stages)


def _stage_values(rows: Sequence[TrainStage], numbers: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What stages have by key, with other numbers by key of the scene."""
    found = [row.model_dump(exclude={"load"}, exclude_none=True) | {"load": row.load} for row in rows]
    for key, value in numbers.items():
        _, number, name = key.split(".")
        found[int(number) - 1][name] = value
    return found


def _link_keys(stage: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """The name of a stage, and the keys of its links."""
    return stage["stage"], {key: each for key, each in stage.items() if key not in ("stage", *CARRIED_KEYS)}


def _with_carried_parts(train: Train, stages: Sequence[Mapping[str, Any]]) -> Train:
    return replace(train, carried=tuple(_carried_parts(stages, train)))


def _carried_parts(stages: Sequence[Mapping[str, Any]], train: Train) -> Iterator[CarriedLoad]:
    """What each stage carries, and the constant forces on it."""
    for number, has in enumerate(stages, start=1):
        joint, turns, unit = _joint_of_stage(train, number)
        if ("mass" if turns else "inertia") in has:
            what, of = ("turns", "an inertia, no mass") if turns else ("slides", "a mass, no inertia")
            raise StageFault(number, f"what it moves {what}: it has {of}")
        if "gravity" in has and "mass" not in has:
            raise StageFault(number, "gravity acts on a mass, which is missing")
        mass = has.get("inertia", 0.0) * 1e3 if turns else has.get("mass", 0.0) * 1e-3
        constant, changing = split_load(has["load"], unit)
        force = constant + has.get("preload", 0.0) * unit + mass * 1e3 * has.get("gravity", 0.0)
        stiffness, friction = (has.get(name, 0.0) * unit for name in ("spring_rate", "friction_force"))
        if changing or any(not isinstance(each, float) or each for each in (mass, stiffness, force, friction)):
            yield CarriedLoad(joint, mass, stiffness, force, friction)
        if "arm_inertia" in has:
            if train.stages.count(number) == 1:
                raise StageFault(number, "it has no arm of its own: arm_inertia goes with an input_arm")
            yield CarriedLoad(joint - 1, has["arm_inertia"] * 1e3)


def _joint_of_stage(train: Train, number: int) -> tuple[int, bool, float]:
    """The joint that a stage moves, whether it turns, and the unit of forces there in N (N·mm)."""
    joint = max(k for k, stage in enumerate(train.stages, start=1) if stage == number)
    turns = train.links[joint - 1].turns[1]
    return joint, turns, 1e3 if turns else 1.0


def train_load(
    rows: Sequence[TrainStage], train: Train | None, load: ExternalLoad | None
) -> ExternalLoad | TrainLoad | None:
    """What comes to a follower besides its own dynamics: a load that changes over the turn, and all of a train."""
    if train is None:
        return load
    loads = [] if load is None else [(0, load)]
    for number, row in enumerate(rows, start=1):
        joint, _, unit = _joint_of_stage(train, number)
        _, changing = split_load(row.load, unit)
        loads += [] if changing is None else [(joint, changing)]
    return TrainLoad(train, tuple(loads)) if train.carried else load


def tool_turns(rows: Sequence[Mapping[str, Any]], turns: bool) -> bool:
    """Whether the tool's motion is an angle, if the follower's is one or not."""
    for row in rows:
        if (name := row.get("stage")) in TRAIN_STAGES:
            turns = TRAIN_STAGES[str(name)].turns(
                {key: each for key, each in row.items() if each is not None}, turns
            )
    return turns


def stages_in(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The stages of the plain mapping of a scene."""
    return tables_in(data.get("train"))


def check_train(scene: "Scene") -> Iterator[Fault]:
    """Every fault of a train: of its stages, what is searched of them, and a tool beyond a dead point."""
    yield from _check_searched_stages(scene)
    try:
        train = _train_without_loads(scene)
    except StageFault as fault:
        yield f"train.{fault.number}", None, str(fault)
        return
    if train is not None:
        yield from _check_dead_points(scene, train)


def _check_searched_stages(scene: "Scene") -> Iterator[Fault]:
    """What ``[search]`` varies of stages that there are not, or have no such number."""
    for number, keys in scene.search.train.items():
        if not (number.isdecimal() and 0 < int(number) <= len(scene.train)):
            yield f"search.train.{number}", None, f"the train of the scene has {stage_count_text(scene)}"
            continue
        stage = scene.train[int(number) - 1]
        for key in keys if stage.stage in TRAIN_STAGES else ():
            where = f"search.train.{number}.{key}"
            if key not in keys_of_stage(stage.stage):
                yield where, VALUE_IN_SCENE, f"{TRAIN_STAGES[stage.stage].words} has no {key}"
            elif isinstance(getattr(stage, key), tuple):
                yield (
                    where,
                    VALUE_IN_SCENE,
                    f"train.{number}.{key} changes over the turn, and no number replaces it",
                )


def stage_count_text(scene: "Scene") -> str:
    """How many stages the train of a scene has, in words."""
    return "1 stage" if len(scene.train) == 1 else f"{len(scene.train) or 'no'} stages"


def _train_without_loads(scene: "Scene") -> Train | None:
    """The train of a scene; None where a value of it, or the follower, is wrong.

    Without the loads of its stages, whose rows are checked on their own (``scene.load``).
    """
    if scene.follower.motion not in MOTIONS or scene.has_wrong("train", all_keys=True):
        return None
    rows = [row.model_copy(update={"load": None}) for row in scene.train]
    return build_train(rows, angular=MOTIONS[scene.follower.motion].angular)


class GivenTurn(NamedTuple):
    """The motion that a scene gives, of its tool or of a follower on a profile, from the start of the train."""

    programme: Programme
    low: float
    """The lowest and the highest position, mm or rad."""
    high: float
    unit: float
    """Of the programme, in mm (rad)."""

    def positions_through(self, train: Train) -> tuple[float, float]:
        """The lowest and the highest position of the other end of a train, from this one."""
        low, high = sorted(value_at_end(train.follower, level) for level in (self.low, self.high))
        return low, high


def _train_from_given_end(scene: "Scene", train: Train) -> Train:
    """The train as one whose tool moves as a scene gives it: turned round where that is the follower."""
    return train.reversed_train if scene.given_at_follower else train


def _given_turn(scene: "Scene", train: Train) -> GivenTurn | None:
    """The motion that a scene gives, of the tool of a train; None where it is not known."""
    if scene.profile:
        try:
            on_profile = known_programme(scene)
        except ProfileFault:  # which is said
            return None
        if on_profile is None:
            return None
        low = -on_profile.strokes[0].low
        return GivenTurn(on_profile, low, low + on_profile.lift, 1.0)
    if (found := turn_of_scene(scene)) is None:
        return None
    given, programme = found
    unit = radians(1.0) if train.angular else 1.0
    low = (start_position(given) - programme.start) * unit
    return GivenTurn(programme, low, low + programme.lift * unit, unit)


def _check_dead_points(scene: "Scene", train: Train) -> Iterator[Fault]:
    """Where the tool, or a follower whose motion is given, does not stay between the dead points of the train."""
    who, train = "follower" if scene.given_at_follower else "tool", _train_from_given_end(scene, train)
    turn = _given_turn(scene, train)
    unit, word = (radians(1.0), "deg") if train.angular else (1.0, "mm")
    for side, end in zip((-1.0, 1.0), train.tool_reach, strict=True) if turn else ():
        assert turn is not None
        farthest, limit = turn.high if side > 0.0 else turn.low, end.at
        if side * farthest >= side * limit - NEAR_DEAD_POINT * abs(limit):
            goes = (
                f"the {who} goes to {farthest / unit:.6g} {word}, and a dead point is at {limit / unit:.6g} {word}"
            )
            cam = _dead_point_angle(turn, side, limit)
            yield f"train.{end.stage}", None, f"{goes}, {cam:.4g} deg of the turn: {end.why} there"


def _dead_point_angle(turn: GivenTurn, side: float, limit: float) -> float:
    """The cam angle, deg, at which a motion comes to a limit on one side of it, or nearest to it."""
    angles = np.linspace(0.0, 2 * np.pi, DEAD_POINT_SAMPLES)
    ahead = side * (turn.low + turn.programme.motion_at(angles)[0] * turn.unit - limit)
    over = np.flatnonzero(ahead >= 0.0)
    return float(np.degrees(angles[over[0] if over.size else int(ahead.argmax())]))


class Lifts(NamedTuple):
    """The highest displacement above the lowest, mm or deg, of a tool and of its follower; None where not known."""

    tool: float | None
    follower: float | None


def lifts_through_train(scene: "Scene", given: float | None) -> Lifts:
    """The lifts of tool and follower of a scene with a train, from that of the motion that it gives."""
    other, train = None, None if any(check_train(scene)) else _train_without_loads(scene)
    if train is not None and (turn := _given_turn(scene, out := _train_from_given_end(scene, train))):
        low, high = turn.positions_through(out)
        other = (high - low) * (degrees(1.0) if out.links[0].turns[0] else 1.0)
    return Lifts(other, given) if scene.given_at_follower else Lifts(given, other)
