"""Follower trains: the stages between a follower and its tool, with their masses, springs and forces."""

from camopt.model.trains import arm, bell_crank, constant_ratio, crank, four_bar, incline
from camopt.model.trains.link import StageKind

TRAIN_STAGES: dict[str, StageKind] = {
    each.STAGE.name: each.STAGE for each in (arm, bell_crank, four_bar, crank, constant_ratio, incline)
}
"""Every kind of stage, by its name in scenes."""
