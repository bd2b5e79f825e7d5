"""The body of a cam and its flanks: the sides that touch the follower."""

from typing import Literal, NamedTuple

CamForm = Literal["disc", "cylindrical"]
"""The forms of cams, as ``cam.form`` has them."""


class Body(NamedTuple):
    """The body of a cam: the keys of its sizes, and the properties of its form."""

    form: CamForm
    words: str
    """What it is called."""
    cam: tuple[str, ...]
    """The keys of ``[cam]`` that it alone has, that of its size first."""
    developed: bool
    """Whether its curves are drawn on its mantle, laid flat. Others turn about the axis in a plane square to it."""
    closed: bool
    """Whether a profile goes round the axis in a plane: it encloses an area, and may cross itself."""
    bounded: bool
    """Whether that profile is its edge: it encloses the section of the cam."""
    part: tuple[str, ...]
    """The keys of ``[part]`` that it alone has."""
    solid: tuple[str, ...]
    """The keys of ``[part]`` without which its mass is not known, the density apart."""
    flank_height: str = ""
    """The key of ``[part]`` that says how high its flanks are; "" of a disc that has them over its thickness."""
    foot: str = ""
    """Where these are the lowest, in words."""

    @property
    def size(self) -> str:
        """The key of its size in ``[cam]``, and in ``[search]``."""
        return self.cam[0]

    @property
    def size_name(self) -> str:
        """The size in words."""
        return self.size.replace("_", " ")

    @property
    def size_quantity(self) -> str:
        """The quantity that says how large it is."""
        return f"{self.size}_mm"


DISC = Body(
    "disc",
    "disc cam",
    cam=("base_radius", "shaft_diameter"),
    developed=False,
    closed=True,
    bounded=True,
    part=("hub_diameter", "hub_length"),
    solid=("thickness",),
)
FACE_GROOVE = Body(
    "disc",
    "grooved disc cam",
    cam=DISC.cam,
    developed=False,
    closed=True,
    bounded=False,
    part=("outer_diameter", "groove_depth", "groove_fit", "groove_chamfer"),
    solid=("thickness", "outer_diameter", "groove_depth"),
    flank_height="groove_depth",
)
CYLINDER = Body(
    "cylindrical",
    "cylindrical cam",
    cam=("mean_radius",),
    developed=True,
    closed=False,
    bounded=False,
    part=("groove_depth", "groove_fit", "groove_chamfer", "outer_fit"),
    solid=("thickness", "groove_depth"),
    flank_height="groove_depth",
    foot="the bottom of the groove",
)
RIBBED_CYLINDER = Body(
    "cylindrical",
    "ribbed cylindrical cam",
    cam=CYLINDER.cam,
    developed=True,
    closed=False,
    bounded=False,
    part=("rib_height", "outer_fit"),
    solid=("thickness", "rib_height"),
    flank_height="rib_height",
    foot="the foot of the rib",
)
RIBBED_DISC = Body(
    "disc",
    "ribbed disc cam",
    cam=DISC.cam,
    developed=False,
    closed=True,
    bounded=False,
    part=("outer_diameter", "rib_height"),
    solid=("thickness", "outer_diameter", "rib_height"),
    flank_height="rib_height",
)
BODIES: dict[str, Body] = {body.form: body for body in (DISC, CYLINDER)}
"""By form: the usual one of each."""
EVERY_BODY = (DISC, FACE_GROOVE, CYLINDER, RIBBED_CYLINDER, RIBBED_DISC)
WHICH_DISC = "disc"
"""What messages call the number of one of the discs of a pair."""


INNER_SIDE = -1.0
"""The side of the trace point on which the profile of an open cam is (``Flank.side``)."""


class Flank(NamedTuple):
    """A side of a cam that touches the follower, one follower radius from the pitch curve."""

    name: str
    """What tells it from the other ones, seen along the motion of the follower over the cam; "" of the only one."""
    side: float
    """Where it is along the outward normal of the pitch curve: −1 below the trace point, +1 beyond it."""
    pressing: float
    """The sign of the normal force N that presses the follower on it."""
    kind: str = "flank"
    """What it is called, after its name."""
    bulge: float = 1.0
    """1 if κ > 0 of the pitch curve bends it towards the follower, −1 if away from it."""

    @property
    def said(self) -> str:
        """It in words."""
        return f"{self.name} {self.kind}"


OUTER = (Flank("", -1.0, 1.0),)
"""The profile of an open cam: it can push the follower outward, and not pull it back."""
GROOVE = (Flank("right", -1.0, 1.0, bulge=-1.0), Flank("left", 1.0, -1.0))
"""Both walls of a groove: the one pushes the roller outward, the other pulls it back."""
FACE_WALLS = (Flank("inner", INNER_SIDE, 1.0, "wall"), Flank("outer", -INNER_SIDE, -1.0, "wall", bulge=-1.0))
"""Those of a groove in the face of a disc, whichever way it turns."""
