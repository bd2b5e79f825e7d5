"""Scenes whose smallest cam is sought: by what binds it, and over the angles of a turn."""

from camopt import Scene

BASE = {
    "cam": {"form": "disc", "rotation": "cw", "rpm": 1000, "base_radius": 60},
    "follower": {"motion": "translating", "contact": "roller", "roller_radius": 5},
    "motion": [
        {"segment": "rise", "angle": 120, "lift": 50, "law": "cycloidal"},
        {"segment": "dwell", "angle": 60},
        {"segment": "return", "angle": 90, "lift": 50, "law": "cycloidal"},
        {"segment": "dwell", "angle": 90},
    ],
    "limits": {"pressure_angle": 30, "pressure_angle_return": 30},
}
VALVE = [
    {"segment": "rise", "angle": 60, "lift": 37.5, "law": "parabolic"},
    {"segment": "dwell", "angle": 20},
    {"segment": "return", "angle": 60, "lift": 37.5, "law": "harmonic"},
    {"segment": "dwell", "angle": 220},
]
SWING = [
    {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"},
    {"segment": "dwell", "angle": 30},
    {"segment": "return", "angle": 100, "lift": 20, "law": "harmonic"},
    {"segment": "dwell", "angle": 110},
]


def scene(**changes):
    return Scene.from_dict(BASE).replace(**changes)


CASES = {
    "pressure binds, offset given": scene(**{"follower.offset": 12.5}),
    "pressure binds, offset free": scene(**{"search.offset": {"start": -30, "stop": 30}}),
    "offset bound": scene(**{"search.offset": {"start": -30, "stop": 3}}),
    "roller free": scene(**{"search.roller_radius": {"start": 5, "stop": 20}}),
    "curvature binds": scene(motion=VALVE, **{"follower.roller_radius": 20, "limits": {"curvature_radius": 5}}),
    "curvature binds, offset free": scene(
        motion=VALVE,
        **{
            "follower.roller_radius": 20,
            "search.offset": {"start": -15, "stop": 15},
            "limits": {"curvature_radius": 5, "pressure_angle": 65},
        },
    ),
    "undercut binds": scene(motion=VALVE, **{"follower.roller_radius": 20, "limits": None}),
    "shaft binds": scene(
        **{"cam.shaft_diameter": 118, "limits.pressure_angle": 60, "limits.pressure_angle_return": 60}
    ),
    "hub binds": scene(
        **{
            "part": {"thickness": 10, "hub_diameter": 118, "hub_length": 20},
            "limits.pressure_angle": 60,
            "limits.pressure_angle_return": 60,
        }
    ),
    "flat": scene(
        motion=VALVE,
        **{
            "follower.contact": "flat",
            "follower.roller_radius": None,
            "cam.base_radius": 300,
            "limits": {"curvature_radius": 2},
        },
    ),
    "spherical": scene(
        **{"follower.contact": "spherical", "follower.roller_radius": None, "follower.face_radius": 30}
    ),
    "knife": scene(**{"follower.contact": "knife", "follower.roller_radius": None}),
    "cylindrical": scene(cam={"form": "cylindrical", "mean_radius": 60}),
    "cylindrical, undercut": scene(
        motion=VALVE,
        cam={"form": "cylindrical", "mean_radius": 60},
        **{"follower.roller_radius": 15, "limits": {"pressure_angle": 70}},
    ),
    "cylindrical oscillating": scene(
        motion=SWING,
        cam={"form": "cylindrical", "mean_radius": 80},
        **{"follower.motion": "oscillating", "follower.arm_length": 100},
    ),
    "oscillating": scene(
        motion=SWING,
        **{
            "follower": {
                "motion": "oscillating",
                "contact": "roller",
                "roller_radius": 10,
                "arm_length": 120,
                "centre_distance": 130,
            },
            "cam.base_radius": 40,
            "limits": {"pressure_angle": 35, "pressure_angle_return": 40},
        },
    ),
    "oscillating flat": scene(
        motion=SWING,
        follower={
            "motion": "oscillating",
            "contact": "flat",
            "centre_distance": 120,
            "face_offset": 8,
        },
        limits={"curvature_radius": 3},
    ),
}


def size_of(row):
    return row.get("base_radius_mm", row.get("mean_radius_mm"))


ANGLES = {"search.angle_rise": {"start": 60, "stop": 160}, "search.angle_return": {"start": 60, "stop": 160}}
OFFSET = {"search.offset": {"start": -40, "stop": 40}}
FREE = {
    "radial": scene(**ANGLES),
    "offset free, limits apart": scene(**ANGLES, **OFFSET, **{"limits.pressure_angle": 35}),
    "an end of the range": scene(**{**ANGLES, "search.angle_rise": {"start": 60, "stop": 90}}),
    "cylindrical": CASES["cylindrical"].replace(**ANGLES),
    "flat": CASES["flat"].replace(
        **{"search.angle_rise": {"start": 40, "stop": 80}, "search.angle_return": {"start": 40, "stop": 80}}
    ),
    "oscillating": CASES["oscillating"].replace(**ANGLES),
    "curvature binds": CASES["curvature binds"].replace(
        **{"search.angle_rise": {"start": 50, "stop": 70}, "search.angle_return": {"start": 50, "stop": 70}}
    ),
}
