"""Write reference.json (whole cams) and laws.json (motion laws) from the reference in tests/support/naive.py.

    python tests/data/make_reference.py

reference.json is a list of {"id", "scene", "expected"}: a scene in the shape of its TOML, and each quantity
as a decimal string of 25 digits, "inf", or a JSON boolean.  Every number of a scene is exact in binary.
laws.json maps a law to its "peaks" (v, a, j; "inf" where the derivative below jumps, the law standing between
dwells) and to its "points": x as a JSON number, meant as the double that it is, with s, v, a, j as decimal
strings of 25 digits.  At x = 0 and x = 1 the derivatives are those from the inside.
"""

import json
import sys
from pathlib import Path
from typing import Any

from mpmath import mp

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from support import naive  # noqa: E402

Scene = dict[str, Any]
DIGITS = 25

# cam and follower of each mechanism; what varies by law is added by `scene_of`
MECHANISMS: dict[str, tuple[Scene, Scene, float]] = {
    "disc-translating-knife": (
        {"form": "disc", "base_radius": 60},
        {"motion": "translating", "contact": "knife"},
        30,
    ),
    "disc-translating-roller": (
        {"form": "disc", "base_radius": 52.5},
        {"motion": "translating", "contact": "roller", "roller_radius": 9.5},
        28,
    ),
    "disc-translating-spherical": (
        {"form": "disc", "base_radius": 45},
        {"motion": "translating", "contact": "spherical", "face_radius": 14},
        22,
    ),
    "disc-translating-flat": (
        {"form": "disc", "base_radius": 72},
        {"motion": "translating", "contact": "flat"},
        15,
    ),
    "disc-oscillating-roller": (
        {"form": "disc", "base_radius": 48},
        {
            "motion": "oscillating",
            "contact": "roller",
            "roller_radius": 11,
            "arm_length": 105,
            "centre_distance": 132,
        },
        18,
    ),
    "disc-oscillating-flat": (
        {"form": "disc", "base_radius": 70},
        {"motion": "oscillating", "contact": "flat", "face_offset": 8, "centre_distance": 140},
        7,
    ),
    "cylindrical-translating": (
        {"form": "cylindrical", "mean_radius": 55},
        {"motion": "translating", "contact": "roller", "roller_radius": 7},
        34,
    ),
    "cylindrical-oscillating": (
        {"form": "cylindrical", "mean_radius": 62},
        {"motion": "oscillating", "contact": "roller", "roller_radius": 8, "arm_length": 90},
        24,
    ),
}

# rise, dwell, return, dwell in degrees, the angle of first dwell taken off the last; one row per law
ANGLES = (
    (0, 110, 40, 95, 115),
    (20, 120, 35, 100, 85),
    (0, 105, 50, 130, 75),
    (15, 135, 30, 115, 65),
    (0, 125, 45, 110, 80),
    (30, 130, 25, 140, 35),
    (0, 128, 42, 112.5, 77.5),
    (10, 118, 36, 142, 54),
)
OFFSETS = (12, -8, 15.5, -14, 6, -10, 18, -5.5)
SPEEDS = (240, 450, 600, 900, 300, 1200, 150, 1000)


def stroke(kind: str, angle: float, lift: float, law: str) -> Scene:
    """One [[motion]] table of a rise or return."""
    return {"segment": kind, "angle": angle, "lift": lift, "law": law}


def dwell(angle: float) -> Scene:
    """One [[motion]] table of a dwell."""
    return {"segment": "dwell", "angle": angle}


def scene_of(mechanism: str, m: int, law: str, k: int) -> Scene:
    """The cam of a mechanism (the m-th) and law (the k-th): offset, rotation, speed and angles vary."""
    cam, follower, lift = MECHANISMS[mechanism]
    before, up, top, down, after = ANGLES[(k + m) % len(ANGLES)]
    cam = cam | {"rotation": ("ccw", "cw")[(k // 2 + m) % 2]}
    if (k + m) % 2:
        cam["rpm"] = SPEEDS[k % len(SPEEDS)]
    if mechanism.startswith("disc-translating"):
        follower = follower | {"offset": OFFSETS[(k + 3 * m) % len(OFFSETS)]}
    motion = [stroke("rise", up, lift, law), dwell(top), stroke("return", down, lift, law), dwell(after)]
    if before:
        motion.insert(0, dwell(before))
    return {"name": f"{mechanism} {law}", "cam": cam, "follower": follower, "motion": motion}


def extra_scenes() -> dict[str, Scene]:
    """Cams outside the grid: undercut ones, several strokes, laws mixed, strokes without a dwell between."""

    def scene_data(mechanism: str, motion: list[Scene], cam: Scene, follower: Scene) -> Scene:
        base = MECHANISMS[mechanism]
        return {"cam": base[0] | cam, "follower": base[1] | follower, "motion": motion}

    turn = [stroke("rise", 80, 30, "cycloidal"), dwell(30), stroke("return", 70, 30, "poly345"), dwell(180)]
    steps = [
        dwell(12.5),
        stroke("rise", 70, 14, "modified-sine"),
        dwell(20),
        stroke("rise", 62.5, 10, "harmonic"),
        stroke("return", 115, 24, "poly4567"),
        dwell(80),
    ]
    through = [
        stroke("rise", 90, 12, "uniform"),
        stroke("rise", 75, 10, "uniform"),
        stroke("return", 195, 22, "cycloidal"),
    ]
    peak = [stroke("rise", 150, 16, "harmonic"), stroke("return", 150, 16, "harmonic"), dwell(60)]
    mixed = [
        stroke("rise", 130, 16, "modified-trapezoid"),
        stroke("return", 110, 6, "parabolic"),
        dwell(20),
        stroke("return", 100, 10, "harmonic"),
    ]
    scenes = {
        "undercut-roller": scene_data(
            "disc-translating-roller",
            turn,
            {"base_radius": 16, "rotation": "cw", "rpm": 500},
            {"roller_radius": 37, "offset": -7},
        ),
        "undercut-flat": scene_data(
            "disc-translating-flat", turn, {"base_radius": 40, "rotation": "cw"}, {"offset": 4}
        ),
        "undercut-oscillating-flat": scene_data(
            "disc-oscillating-flat",
            [stroke("rise", 75, 12, "poly345"), dwell(60), stroke("return", 90, 12, "harmonic"), dwell(135)],
            {"base_radius": 36, "rotation": "ccw"},
            {},
        ),
        "undercut-cylinder": scene_data(
            "cylindrical-translating", turn, {"mean_radius": 30, "rotation": "cw"}, {"roller_radius": 12}
        ),
        "steps-roller": scene_data(
            "disc-translating-roller", steps, {"rotation": "cw", "rpm": 720}, {"offset": 11}
        ),
        "steps-oscillating": scene_data("disc-oscillating-roller", steps, {"rotation": "cw"}, {}),
        "steps-cylinder-oscillating": scene_data("cylindrical-oscillating", steps, {"rpm": 90}, {}),
        "corners-knife": scene_data("disc-translating-knife", through, {"rotation": "cw"}, {"offset": -9}),
        "no-dwell-at-top": scene_data("disc-translating-spherical", peak, {"rpm": 333}, {"offset": 3}),
        "mixed-knife": scene_data(
            "disc-translating-knife", mixed, {"rotation": "ccw", "rpm": 800}, {"offset": -21}
        ),
        "mixed-flat-radial": scene_data("disc-translating-flat", mixed, {}, {}),
        "roller-radial-default-rotation": scene_data("disc-translating-roller", mixed, {"rpm": 60}, {}),
        "oscillating-knife": {
            "cam": {"form": "disc", "base_radius": 55, "rotation": "cw", "rpm": 210},
            "follower": {
                "motion": "oscillating",
                "contact": "knife",
                "arm_length": 120,
                "centre_distance": 110,
            },
            "motion": mixed,
        },
        "oscillating-spherical": {
            "cam": {"form": "disc", "base_radius": 42, "rotation": "ccw"},
            "follower": {
                "motion": "oscillating",
                "contact": "spherical",
                "face_radius": 17.5,
                "arm_length": 80,
                "centre_distance": 118,
            },
            "motion": mixed,
        },
        "oscillating-flat-face-through-pivot": scene_data(
            "disc-oscillating-flat",
            [stroke("rise", 140, 6, "cycloidal"), stroke("return", 150, 6, "modified-sine"), dwell(70)],
            {"rotation": "cw", "rpm": 410},
            {"face_offset": 0},
        ),
        "oscillating-flat-face-inside": scene_data(
            "disc-oscillating-flat",
            [dwell(30), stroke("rise", 140, 6, "poly4567"), stroke("return", 120, 6, "harmonic"), dwell(70)],
            {"rotation": "ccw"},
            {"face_offset": -12},
        ),
    }
    return {name: {"name": name} | scene for name, scene in scenes.items()}


def scenes() -> dict[str, Scene]:
    """Every scene of the reference by its id: mechanism x law, then the extras."""
    grid = {
        f"{mechanism}-{law}": scene_of(mechanism, m, law, k)
        for m, mechanism in enumerate(MECHANISMS)
        for k, law in enumerate(naive.COMMON)
    }
    return grid | extra_scenes()


def text(value: Any) -> str | bool:
    """A value as it stands in the files."""
    if isinstance(value, bool):
        return value
    if value == mp.inf:
        return "inf"
    return mp.nstr(value, DIGITS) if abs(value) > mp.mpf(10) ** (10 - mp.dps) else "0.0"  # the rest is rounding


def abscissae(law: str) -> list[float]:
    """About 40 doubles in [0, 1]: tiny, beside 1, a grid, and both sides of every break (not the break)."""
    breaks = [float(x1) for _, x1, _ in naive.law_pieces(law)[:-1]] or [0.5]
    beside = [b + d for b in breaks for d in (-1e-3, -1e-8, 1e-8, 1e-3)]
    ends = [0.0, 1e-8, 1e-5, 1e-3, 1e-2, 1 - 1e-2, 1 - 1e-3, 1 - 1e-5, 1 - 1e-8, 1.0]
    grid = [k / 23 for k in range(1, 23)]
    return sorted({*ends, *beside, *grid} - set(breaks))


def law_table(law: str) -> Scene:
    """Points and peaks of one law."""
    with mp.workdps(90):
        rows = [(x, [text(v) for v in naive.law_at(law, mp.mpf(x))]) for x in abscissae(law)]
    peaks = [text(v) for v in naive.law_peaks(law)]
    return {
        "peaks": dict(zip("vaj", peaks, strict=True)),
        "points": [{"x": x} | dict(zip("svaj", row, strict=True)) for x, row in rows],
    }


def write(name: str, content: Any) -> None:
    """Write one JSON file beside this script."""
    (HERE / name).write_text(json.dumps(content, indent=1) + "\n")


def main() -> None:
    """Write both files, or with the word ``laws`` that of the laws alone; reference.json grows as it goes."""
    write("laws.json", {law: law_table(law) for law in naive.LAWS})
    if sys.argv[1:] == ["laws"]:
        return
    entries = []
    for name, scene in scenes().items():
        expected = {key: text(value) for key, value in naive.evaluate(scene).items()}
        entries.append({"id": name, "scene": scene, "expected": expected})
        print(name, expected.get("profile_radius_min_mm"), file=sys.stderr)
    write("reference.json", entries)


if __name__ == "__main__":
    main()
