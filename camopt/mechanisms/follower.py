"""The motion of a follower, and its tip, which touches the cam."""

from typing import Literal, NamedTuple

from camopt.quantities.scene_numbers import NUMBERS

MotionName = Literal["translating", "oscillating"]
"""How followers move, as ``follower.motion`` has it."""
TipName = Literal["knife", "roller", "flat", "spherical"]
"""What touches the cam, as ``follower.contact`` has it."""


class FollowerMotion(NamedTuple):
    """The way in which a follower moves: along a line, or about a pivot."""

    name: MotionName
    words: str
    """The name with its article."""
    angular: bool
    """Whether its displacement is an angle, and what moves it a moment."""
    unit: str
    """Of its displacement in a scene."""

    @property
    def dynamics(self) -> tuple[str, ...]:
        """The keys of ``[follower.dynamics]`` that it alone has."""
        return tuple(each.name for each in NUMBERS if (each.turns if self.angular else each.slides))


TRANSLATING = FollowerMotion("translating", "a translating", angular=False, unit="mm")
OSCILLATING = FollowerMotion("oscillating", "an oscillating", angular=True, unit="deg")
MOTIONS: dict[str, FollowerMotion] = {motion.name: motion for motion in (TRANSLATING, OSCILLATING)}


class Tip(NamedTuple):
    """The tip of a follower, which touches the cam."""

    name: TipName
    radius: str = ""
    """The key of its radius in ``[follower]``; "" if it has none."""
    trace: str = ""
    """What its trace point is, in words."""


KNIFE, ROLLER, FLAT, SPHERICAL = (
    Tip("knife", trace="knife edge"),
    Tip("roller", "roller_radius", "roller centre"),
    Tip("flat"),
    Tip("spherical", "face_radius", "face centre"),
)
TIPS: dict[str, Tip] = {tip.name: tip for tip in (KNIFE, ROLLER, FLAT, SPHERICAL)}
ROUND = (KNIFE, ROLLER, SPHERICAL)
"""Tips with a trace point: the edge, or the centre of the roller or face."""
