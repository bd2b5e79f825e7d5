"""Follower trains: the stages between a follower and its tool, with their masses, springs and forces."""

from camopt.model.trains import bell_crank, four_bar, incline, ratio, rocker, slider_crank
from camopt.model.trains.link import StageKind

TRAIN_STAGES: dict[str, StageKind] = {
    each.STAGE.name: each.STAGE for each in (rocker, bell_crank, four_bar, slider_crank, ratio, incline)
}
"""Every kind of stage, by its name in scenes."""
