"""The elements of mechanisms: bodies of cams, motions and tips of followers, and drives.

The body of a cam has flanks, the sides that touch the follower. A follower has a motion, and a tip that touches the
cam. A drive keeps the tip on the cam: a spring, a groove whose walls push and pull, or two contacts.
"""

from typing import Literal, NamedTuple

from camopt.core.quantities.scene_numbers import NUMBERS

CamForm = Literal["disc", "cylindrical"]
"""The forms of cams, the values of ``cam.form``."""


class Body(NamedTuple):
    """The body of a cam: the keys of its sizes, and the properties of its form."""

    form: CamForm
    words: str
    """Its name in sentences."""
    cam: tuple[str, ...]
    """The keys of ``[cam]`` that only this body has; that of its size first."""
    developed: bool
    """Whether its curves are drawn on the developed cylinder; if not, in a plane square to the axis."""
    closed: bool
    """Whether a profile goes round the axis in a plane: it encloses an area, and may cross itself."""
    bounded: bool
    """Whether the profile is the edge of the cam, so that it encloses the cam's section."""
    part: tuple[str, ...]
    """The keys of ``[part]`` that only this body has."""
    solid: tuple[str, ...]
    """The keys of ``[part]`` that its mass needs, besides the density."""
    flank_height: str = ""
    """The key of ``[part]`` for the height of its flanks; "" if they go over the thickness of the disc."""
    foot: str = ""
    """The lowest place of the flanks, in words."""

    @property
    def size_key(self) -> str:
        """The key of its size in ``[cam]``, and in ``[search]``."""
        return self.cam[0]

    @property
    def size_name(self) -> str:
        return self.size_key.replace("_", " ")

    @property
    def size_quantity(self) -> str:
        """The quantity of its size in tables."""
        return f"{self.size_key}_mm"


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
"""The usual body of each form."""
EVERY_BODY = (DISC, FACE_GROOVE, CYLINDER, RIBBED_CYLINDER, RIBBED_DISC)
WHICH_DISC = "disc"
"""The word before the number of a pair's disc, in messages."""


INNER_SIDE = -1.0
"""The side of an open cam's profile, seen from the trace point (``Flank.side``)."""


class Flank(NamedTuple):
    """A side of a cam that touches the follower, one follower radius from the pitch curve."""

    name: str
    """Its name, as seen along the motion of the follower over the cam; "" for the only flank."""
    side: float
    """Its side along the outward normal of the pitch curve: −1 below the trace point, +1 beyond it."""
    pressing: float
    """The sign of the normal force that presses the follower on it."""
    kind: str = "flank"
    """The noun after its name."""
    bulge: float = 1.0
    """1 if κ > 0 of the pitch curve bends the flank towards the follower, −1 if away from it."""

    @property
    def display_name(self) -> str:
        """Name and noun, such as "inner wall"."""
        return f"{self.name} {self.kind}"


OUTER_PROFILE = (Flank("", -1.0, 1.0),)
"""The profile of an open cam: it pushes the follower outward, and cannot pull it back."""
GROOVE_WALLS = (Flank("right", -1.0, 1.0, bulge=-1.0), Flank("left", 1.0, -1.0))
"""The walls of a groove: one pushes the roller outward, the other pulls it back."""
FACE_WALLS = (Flank("inner", INNER_SIDE, 1.0, "wall"), Flank("outer", -INNER_SIDE, -1.0, "wall", bulge=-1.0))
"""The walls of a groove in the face of a disc, whichever way it turns."""


MotionName = Literal["translating", "oscillating"]
"""The motions of followers, the values of ``follower.motion``."""
TipName = Literal["knife", "roller", "flat", "spherical"]
"""The tips of followers, the values of ``follower.contact``."""


class FollowerMotion(NamedTuple):
    """The motion of a follower: along a line, or about a pivot."""

    name: MotionName
    words: str
    """The name with its article."""
    angular: bool
    """Whether its displacement is an angle, and its load a moment."""
    unit: str
    """The unit of its displacement in a scene."""

    @property
    def own_dynamics_keys(self) -> tuple[str, ...]:
        """The keys of ``[follower.dynamics]`` that only this motion has."""
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
    """Its trace point, in words."""


KNIFE, ROLLER, FLAT, SPHERICAL = (
    Tip("knife", trace="knife edge"),
    Tip("roller", "roller_radius", "roller centre"),
    Tip("flat"),
    Tip("spherical", "face_radius", "face centre"),
)
TIPS: dict[str, Tip] = {tip.name: tip for tip in (KNIFE, ROLLER, FLAT, SPHERICAL)}
ROUND_TIPS = (KNIFE, ROLLER, SPHERICAL)
"""Tips with a trace point: the edge, or the centre of the roller or face."""


DriveName = Literal["spring", "groove", "conjugate", "breadth", "diameter", "rib"]
"""The drives that keep a follower on its cam, the values of ``drive.kind``."""


class DriveKind(NamedTuple):
    """A way to keep a follower on its cam."""

    name: DriveName
    words: str
    """The name with its article."""
    flanks: tuple[Flank, ...]
    """The sides of the cam that touch the follower."""
    keys: tuple[str, ...] = ()
    """The keys of ``[drive]`` that it has, besides ``kind``."""
    one_disc: bool = False
    """Whether both contacts of the follower are on one disc, half a turn apart."""


SPRUNG = DriveKind("spring", "a spring", flanks=OUTER_PROFILE)
GROOVED = DriveKind("groove", "a groove", flanks=GROOVE_WALLS, keys=("clearance", "roller_inertia", "friction"))
PRELOAD = ("interference", "stiffness")
"""The keys of a preload between two contacts."""
CONJUGATE = DriveKind(
    "conjugate", "a conjugate pair", flanks=OUTER_PROFILE, keys=(*PRELOAD, "base_radius", "roller_radius")
)
BREADTH_YOKE = DriveKind("breadth", "a yoke of constant breadth", flanks=OUTER_PROFILE, keys=PRELOAD, one_disc=True)
DIAMETER_YOKE = DriveKind(
    "diameter", "a yoke of constant diameter", flanks=OUTER_PROFILE, keys=PRELOAD, one_disc=True
)
RIBBED = DriveKind("rib", "a rib", flanks=OUTER_PROFILE, keys=(*PRELOAD, "clearance"))
DRIVES: dict[str, DriveKind] = {
    drive.name: drive for drive in (SPRUNG, GROOVED, CONJUGATE, BREADTH_YOKE, DIAMETER_YOKE, RIBBED)
}
