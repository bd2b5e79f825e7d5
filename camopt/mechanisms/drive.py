"""What keeps a follower on its cam: a spring, flanks of the cam that push it and pull it back, or two contacts."""

from typing import Literal, NamedTuple

from camopt.mechanisms.body import GROOVE, OUTER, Flank

DriveName = Literal["spring", "groove", "conjugate", "breadth", "diameter", "rib"]
"""What keeps a follower on its cam, as ``drive.kind`` has it."""


class Drive(NamedTuple):
    """A way to keep a follower on its cam. Mechanisms say on which cams, and with which followers, there is one."""

    name: DriveName
    words: str
    """The name with its article."""
    flanks: tuple[Flank, ...]
    """The sides of the cam that touch the follower."""
    keys: tuple[str, ...] = ()
    """The keys of ``[drive]`` that it has, besides its kind."""
    one_disc: bool = False
    """Whether two contacts of the follower are on one disc, half a turn apart."""


SPRUNG = Drive("spring", "a spring", flanks=OUTER)
GROOVED = Drive("groove", "a groove", flanks=GROOVE, keys=("clearance", "roller_inertia", "friction"))
PRELOAD = ("interference", "stiffness")
"""The keys of a preload between two contacts."""
CONJUGATE = Drive("conjugate", "a conjugate pair", flanks=OUTER, keys=(*PRELOAD, "base_radius", "roller_radius"))
BREADTH = Drive("breadth", "a yoke of constant breadth", flanks=OUTER, keys=PRELOAD, one_disc=True)
DIAMETER = Drive("diameter", "a yoke of constant diameter", flanks=OUTER, keys=PRELOAD, one_disc=True)
RIBBED = Drive("rib", "a rib", flanks=OUTER, keys=(*PRELOAD, "clearance"))
DRIVES: dict[str, Drive] = {drive.name: drive for drive in (SPRUNG, GROOVED, CONJUGATE, BREADTH, DIAMETER, RIBBED)}
