"""From the motion that a scene asks of its tool to that of its follower, or from a given cam to its tool."""

from collections.abc import Sequence
from dataclasses import replace

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment, start_position
from camopt.model.motion.tool_drive import follower_programme, programme_with_tool
from camopt.model.trains.train import StageFault, Train
from camopt.scene.checks import faults_of
from camopt.scene.scene import Scene


def motion_through_train(
    asked: Programme,
    segments: Sequence[MotionSegment],
    scene: Scene,
    train: Train | None,
    load: ExternalLoad | TrainLoad | None,
) -> Programme:
    """The turn of the follower of a scene, under a load; without a train it is what is asked.

    On a given profile, and where the motion is given at the follower, its turn is known, and comes with that of the
    tool.

    Raises
    ------
    BadInput
        If the tool, or a follower whose motion is given, goes beyond a dead point of the train.
    """
    if train is None:
        return asked
    zero = (start_position(segments) - asked.start) * asked.unit
    drive = programme_with_tool if scene.given_at_follower else follower_programme
    try:
        return drive(replace(asked, load=None), train, zero, load)
    except StageFault as fault:
        raise BadInput([Mistake(scene.file, f"train.{fault.number}", None, str(fault), bare=True)]) from None


def train_fault(scene: Scene) -> str:
    """Why the train of a scene cannot move its follower as asked; empty if it can."""
    faults = (
        fault for fault in faults_of(scene, scene.to_dict()) if fault[0].startswith(("train", "follower.dynamics"))
    )
    return next((f"{key}: {why}" for key, _, why in faults), "")
