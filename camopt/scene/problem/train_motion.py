"""The motion of the follower from that of the tool through a train, or the reverse."""

from collections.abc import Sequence
from dataclasses import replace

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment, start_position
from camopt.model.motion.tool_drive import follower_programme, programme_with_tool
from camopt.model.trains.train import StageFault, Train
from camopt.scene.checks import faults_across_tables
from camopt.scene.load import split_constant_and_changing_load
from camopt.scene.problem.setup import external_load_and_its_unit
from camopt.scene.scene import Scene
from camopt.scene.train import follower_load_with_train


def follower_motion_through_train(
    given_motion: Programme,
    segments: Sequence[MotionSegment],
    scene: Scene,
    train: Train | None,
) -> Programme:
    """The motion of the follower of a scene, under its load; without a train it is the given motion.

    If the scene gives the motion of the follower, or its profile, the result has the motion of the tool added.

    Raises
    ------
    BadInput
        If the tool, or a follower with a given motion, goes beyond a dead point of the train.
    """
    if train is None:
        return given_motion
    zero = (start_position(segments) - given_motion.start) * given_motion.unit_in_mm_or_rad
    drive = programme_with_tool if scene.given_at_follower else follower_programme
    _, external_load = split_constant_and_changing_load(*external_load_and_its_unit(scene))
    load = follower_load_with_train(scene.train, train, external_load)
    try:
        return drive(replace(given_motion, load=None), train, zero, load)
    except StageFault as fault:
        raise BadInput([Mistake(scene.file, f"train.{fault.number}", None, str(fault), bare=True)], scene) from None


def train_fault(scene: Scene) -> str:
    """Why the train of a scene cannot perform the given motion; empty if it can."""
    faults = (
        fault
        for fault in faults_across_tables(scene, scene.to_dict())
        if fault[0].startswith(("train", "follower.dynamics"))
    )
    return next((f"{key}: {why}" for key, _, why in faults), "")
