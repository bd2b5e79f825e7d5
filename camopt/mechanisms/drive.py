"""What keeps a follower on its cam: a spring, or flanks of the cam that push it and pull it back."""

from dataclasses import dataclass
from typing import Literal

from camopt.mechanisms.body import GROOVE, OUTER, Flank

DriveName = Literal["spring", "groove"]
"""What keeps a follower on its cam, as ``drive.kind`` has it."""


@dataclass(frozen=True)
class Drive:
    """A way to keep a follower on its cam. Mechanisms say on which cams, and with which followers, there is one."""

    name: DriveName
    words: str
    """The name with its article."""
    flanks: tuple[Flank, ...]
    """The sides of the cam that touch the follower."""
    keys: tuple[str, ...] = ()
    """The keys of ``[drive]`` that it has, besides its kind."""


SPRUNG = Drive("spring", "a spring", flanks=OUTER)
GROOVED = Drive("groove", "a groove", flanks=GROOVE)
DRIVES: dict[str, Drive] = {drive.name: drive for drive in (SPRUNG, GROOVED)}
