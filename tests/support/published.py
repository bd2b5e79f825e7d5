"""Numbers and closed forms of published sources: for the tests, and for the page of the site.

Each case says whether its source was read, or is quoted from memory. A number stands as its source has it, so that
its digits are its tolerance: half a unit of the last one. Where the source itself rounds on its way, or an
approximation is compared, ``within`` says by how much, and a note why.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, partial
from math import cos, degrees, hypot, pi, radians, sin, sqrt
from typing import NamedTuple

import numpy as np

import camopt
from camopt.core.numerics.point_contact import contact_half_axis_ratio
from camopt.model.effects.hertz import SHEAR_DEPTH, SHEAR_SHARE
from camopt.scene.problem.problem import resolve_design

INCH, POUND, GRAVITY = 25.4, 4.4482216152605, 386.0  # mm, N, in/s² as the handbook rounds it
LECTURE_NOTES = "lecture notes on cams (MP 3010, *Kinematics and Dynamics*), which print it"
FROM_MEMORY = "Quoted from memory, not seen in print."
ROUNDED = 1.002  # half units of the last digit: a tie in decimals is none in binary


class Answer(NamedTuple):
    """One number in print: a text as it is printed, or the value of a printed formula."""

    what: str
    printed: str | float
    unit: str = ""
    within: float | None = None
    """The largest difference allowed, in the unit; of a text half a unit of its last digit if not given."""

    @property
    def value(self) -> float:
        return float(self.printed)

    @property
    def allowed_error(self) -> float:
        if self.within is not None:
            return self.within
        exponent = Decimal(str(self.printed)).as_tuple().exponent
        assert isinstance(exponent, int)
        return ROUNDED * 0.5 * 10.0**exponent


@dataclass(frozen=True)
class Case:
    """Published answers, and what camopt says to the same inputs."""

    topic: str
    name: str
    source: str
    inputs: str
    answers: Sequence[Answer]
    ours: Callable[[], Sequence[float]]
    """The values in the order of the answers."""
    note: str = ""
    """What is loose in the source, or why its digits are not all met."""
    read: str = ""
    """Where its text was read; "" if it is quoted from memory, and nobody is known to have seen it in print."""

    @property
    def second_answer_text(self) -> str:
        """In words."""
        return f"Read in {self.read}." if self.read else FROM_MEMORY


def turn_of(law, lift, angles, back=None):
    kinds = ("rise", "dwell", "return", "dwell")
    moving = {"rise": {"lift": lift, "law": law}, "return": {"lift": lift, "law": back or law}}
    return [
        {"segment": kind, "angle": angle, **moving.get(kind, {})} for kind, angle in zip(kinds, angles, strict=True)
    ]


def scene_of(follower, dynamics, motion, rpm, **more):
    base_radius = more.pop("base_radius", 60.0)
    return camopt.Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": base_radius, "rpm": rpm},
            "follower": {"motion": "translating", **follower, "dynamics": dynamics},
            "motion": motion,
            **more,
        }
    )


# ---------------------------------------------------------------------------------------------- motion laws


def peaks_of_rises(laws):
    """C_v, C_a and C_j of laws, from a rise over 90° of a flat-faced follower; those that are infinite left out."""
    found = []
    for law in laws:
        motion = turn_of(law, 1.0, (90, 90, 90, 90))
        cam, follower = {"form": "disc", "base_radius": 60.0}, {"motion": "translating", "contact": "flat"}
        design = camopt.evaluate(camopt.Scene.from_dict({"cam": cam, "follower": follower, "motion": motion}))
        names = ("velocity_max_rise_mm_per_rad", "acceleration_max_rise_mm_per_rad2", "jerk_max_rise_mm_per_rad3")
        peaks = [design[name] * (pi / 2) ** order for order, name in enumerate(names, start=1)]
        found += [peak for peak in peaks if peak < np.inf]
    return found


VDI = {
    "parabolic": ("2.00", "4.00"),
    "harmonic": ("1.57", "4.93"),
    "cycloidal": ("2.00", "6.28", "39.48"),
    "poly345": ("1.88", "5.77", "60.00"),
    "modified-sine": ("1.76", "5.53", "69.47"),
    "modified-trapezoid": ("2.00", "4.89", "61.43"),
}
NORTON = {"modified-trapezoid": ("2.000", "4.888", "61"), "modified-sine": ("1.760", "5.528", "69")}


def peak_answers(laws):
    symbols = ("$C_v$", "$C_a$", "$C_j$")
    return [Answer(f"{law}, {s}", p) for law, row in laws.items() for s, p in zip(symbols, row, strict=False)]


def torque_characteristics():
    h, angle, omega, mass, found = 0.03, radians(110), 20 * pi, 0.4, []
    for law in ("modified-trapezoid", "modified-sine"):
        motion = turn_of(law, 30.0, (110, 70, 180, 0))
        scene = scene_of({"contact": "flat"}, {"mass": mass}, motion, 600.0, outputs=["torque"])
        found.append(camopt.evaluate(scene)["torque_max_N_m"] / (mass * omega**2 * h**2 / angle**3))
    return found


def halves():
    at = np.array([0.0, 0.5, 1.0])
    return [float(v) for name, verb in HALVES for v in getattr(camopt.LAWS[name], verb)(at)]


HALVES = {
    ("half-cycloidal-1", "velocity"): (0.0, 1.0, 2.0),
    ("half-cycloidal-1", "acceleration"): (0.0, pi, 0.0),
    ("half-cycloidal-2", "velocity"): (2.0, 1.0, 0.0),
    ("half-cycloidal-2", "acceleration"): (0.0, -pi, 0.0),
    ("half-harmonic-1", "velocity"): (0.0, pi / sqrt(8), pi / 2),
    ("half-harmonic-1", "acceleration"): (pi**2 / 4, pi**2 / sqrt(32), 0.0),
    ("half-harmonic-2", "velocity"): (pi / 2, pi / sqrt(8), 0.0),
    ("half-harmonic-2", "acceleration"): (0.0, -(pi**2) / sqrt(32), -(pi**2) / 4),
}

# ------------------------------------------------------------------------------------------------- textbooks


def strokes_of(name):
    found = camopt.evaluate(camopt.find_scene(name))
    names = [f"{what}_max_{stroke}" for what in ("velocity", "acceleration") for stroke in ("rise", "return")]
    return [found[f"{each}_m_s{'2' if each.startswith('acc') else ''}"] for each in names]


def khurmi(velocities, accelerations):
    answers = [
        Answer(f"velocity, {s}", v, "m/s", 0.0075) for s, v in zip(("rise", "return"), velocities, strict=True)
    ]
    pairs = zip(("rise", "return"), accelerations, strict=True)
    return [*answers, *(Answer(f"acceleration, {s}", a, "m/s²", 2e-3 * float(a)) for s, a in pairs)]


def tangent_cam():
    programme, omega = resolve_design(camopt.find_scene("tangent-cam")).programme, 4 * pi
    _, flank, nose, _ = programme.strokes
    inside = flank.end - 1e-9, nose.start + nose.angle / 2
    leaving, top = omega**2 * programme.motion_at(np.array(inside))[2] / 1e3
    return degrees(flank.angle), float(leaving), -float(top)


# ----------------------------------------------------------------------------------------------------- force

SKEWED = {  # 4x² to x = 1/4, then 1 − (4/3)(1 − x)²: acceleration three times the deceleration
    "degree": 3,
    "knots": [0, 0, 0, 0, 0.25, 0.25, 1, 1, 1, 1],
    "coefficients": [0, 0, 1 / 12, 0.75, 1, 1],
}
TURNED = {
    "degree": 3,
    "knots": [0, 0, 0, 0, 0.75, 0.75, 1, 1, 1, 1],
    "coefficients": [0, 0, 0.25, 11 / 12, 1, 1],
}


def rothbart(**changes):
    """The spring of Fig. 8.7: 14 lb at the start and 30 lb at the transition, 5/16 in higher."""
    spring = {"mass": 2 / GRAVITY * POUND / INCH * 1e3, "load": 12 * POUND}
    spring |= {"preload": 14 * POUND, "spring_rate": 16 / (5 / 16) * POUND / INCH, **changes}
    motion = turn_of("skewed", 1.25 * INCH, (160, 20, 160, 20), "turned")
    laws = {"skewed": SKEWED, "turned": TURNED}
    return camopt.evaluate(
        scene_of({"contact": "flat"}, spring, motion, 1200.0, laws=laws, outputs=["force", "motion"])
    )


def loads_on_the_cam():
    sprung, bare = rothbart(), rothbart(preload=0.0, spring_rate=0.0)
    return (
        sprung["acceleration_max_m_s2"] * 1e3 / INCH,
        sprung["contact_force_max_N"] / POUND,
        sprung["contact_force_min_N"] / POUND,
        bare["preload_required_N"] / POUND,
        bare["contact_force_max_N"] / POUND,
    )


MASS, RATE, PRELOAD, ECCENTRICITY = 1.2, 4.0, 90.0, 8.0
JUMP = sqrt((2 * RATE * ECCENTRICITY + PRELOAD) / (1e-3 * MASS * ECCENTRICITY)) * 30 / pi


@cache
def eccentric(rpm):
    dynamics = {"mass": MASS, "spring_rate": RATE, "preload": PRELOAD}
    half = {"angle": 180.0, "lift": 2 * ECCENTRICITY, "law": "harmonic"}
    motion = [{"segment": "rise", **half}, {"segment": "return", **half}]
    more = {"outputs": ["force", "torque"], "accuracy": {"tolerance": 1e-3}}  # of its curvature, which is constant
    return camopt.evaluate(scene_of({"contact": "flat"}, dynamics, motion, rpm, **more))


def torque_in_print():
    """T = e(ke + P)·sin ωt + ½e²(mω² − k)·sin 2ωt at 300 rev/min: its extremes, mean and root mean square."""
    first = 1e-3 * ECCENTRICITY * (RATE * ECCENTRICITY + PRELOAD)
    second = 1e-3 * ECCENTRICITY**2 * (1e-3 * MASS * (10 * pi) ** 2 - RATE) / 2
    level = (sqrt(first**2 + 32 * second**2) - first) / (8 * second)  # cos ωt where dT/dt = 0
    largest = sqrt(1 - level**2) * (first + 2 * second * level)
    return largest, -largest, hypot(first, second) / sqrt(2)


def flywheel():
    """The energy goes into 56 kN lifted by 1 m; then, with the book's flywheel, by how much its speed differs."""
    dynamics = {"mass": 1e-9, "load": 56e3, "fluctuation": 0.01}
    motion = turn_of("cycloidal", 1000.0, (120, 60, 120, 60))
    found = camopt.evaluate(scene_of({"contact": "flat"}, dynamics, motion, 120.0, outputs=["torque"]))
    apart = 0.01 * 120 * found["flywheel_inertia_kg_m2"] / (6500 * 1.8**2)
    return found["energy_fluctuation_J"] / 1e3, 120 + apart / 2, 120 - apart / 2


# --------------------------------------------------------------------------------------------------- contact

ELLIPSES = {  # θ, deg: m, n
    30: ("2.731", "0.493"), 35: ("2.397", "0.530"), 40: ("2.136", "0.567"), 45: ("1.926", "0.604"),
    50: ("1.754", "0.641"), 55: ("1.611", "0.678"), 60: ("1.486", "0.717"), 65: ("1.378", "0.759"),
    70: ("1.284", "0.802"), 75: ("1.202", "0.846"), 80: ("1.128", "0.893"), 85: ("1.061", "0.944"),
}  # fmt: skip
STEEL = {"cam_modulus": 200, "cam_poisson": 0.3, "follower_modulus": 200, "follower_poisson": 0.3}


def stress_of_spherical_face(face_radius, load, base_radius, materials):
    """A spherical face on a round cam, which all but stands still."""
    follower = {"contact": "spherical", "face_radius": face_radius}
    motion, still = turn_of("cycloidal", 1e-9, (90, 90, 90, 90)), {"mass": 1e-9, "preload": load}
    more = {"materials": materials, "base_radius": base_radius, "outputs": ["hertz"]}
    return camopt.evaluate(scene_of(follower, still, motion, 1e-3, **more))


def ellipses():
    load, radius, modulus, axes = 400.0, 30.0, 200e3 / (2 * (1 - 0.3**2)), []
    for angle in ELLIPSES:
        base_radius = radius * (1 - cos(radians(angle))) / (2 * cos(radians(angle)))
        found = stress_of_spherical_face(radius, load, base_radius, STEEL)
        scale = np.cbrt(3 * load / (4 * modulus * (1 / radius + 1 / (2 * base_radius))))
        axes += [float(found[f"contact_half_{name}_mm"] / scale) for name in ("length", "width")]
    return axes


def sphere_on_a_plane():
    rubber = {"cam_modulus": 1e12, "cam_poisson": 0.3, "follower_modulus": 1, "follower_poisson": 0.3}
    found = stress_of_spherical_face(8.0, 60 * pi, 1e9, rubber)
    return found["contact_half_width_mm"], found["contact_half_length_mm"]


FLAT = np.geomspace(1.0, 25.0, 9)
"""Ratios of the radii R_y/R_x."""

# ------------------------------------------------------------------------------------------------- vibration

AYRE = {  # residual amplitudes by the time of the front over the natural period
    "uniform": lambda r: abs(sin(pi * r) / (pi * r)),
    "harmonic": lambda r: abs(cos(pi * r) / (1 - 4 * r * r)),
    "cycloidal": lambda r: abs(sin(pi * r) / (pi * r * (1 - r * r))),
}
RATIOS = (0.15, 0.35, 0.75, 1.25, 1.6, 2.3, 3.7, 6.45)
STILL = {"uniform": (1, 2, 3, 4), "harmonic": (1.5, 2.5, 3.5), "cycloidal": (2, 3, 4, 5)}


def residuals(at, name="residual"):
    return [float(v) for law, ratios in at.items() for v in camopt.response_spectrum(law, ratios)[name]]


FRONTS = dict.fromkeys(AYRE, RATIOS)
FRONT = {"uniform": "constant slope", "harmonic": "versed sine", "cycloidal": "cycloid"}

CASES = (
    Case(
        "Motion laws",
        "Peak factors of the standardised laws",
        "VDI 2143, sheet 1 (1980): characteristic values $C_v$, $C_a$, $C_j$",
        "a rise from rest to rest",
        peak_answers(VDI),
        partial(peaks_of_rises, VDI),
        "The jerk of parabolic and harmonic motion is infinite at the ends.",
    ),
    Case(
        "Motion laws",
        "Peak factors of modified laws",
        "Norton, *Design of Machinery*, ch. 8, table of peak factors",
        "a rise from rest to rest",
        peak_answers(NORTON),
        partial(peaks_of_rises, NORTON),
    ),
    Case(
        "Motion laws",
        "Torque characteristic, the largest $v a$",
        "tables of laws (Makino; Koumura)",
        "a mass of 0.4 kg, 30 mm in 110° at 600 rev/min",
        [Answer("modified-trapezoid", "8.09"), Answer("modified-sine", "5.46")],
        torque_characteristics,
    ),
    Case(
        "Motion laws",
        "Velocity and acceleration of half curves",
        "Kloomok and Muffley, *Product Engineering*, Feb. 1955, by the angle of the half",
        "start, middle and end of the stroke",
        [
            Answer(f"{law}, {what[0]}({x:g})", value, "", 1e-15)
            for (law, what), values in HALVES.items()
            for x, value in zip((0, 0.5, 1), values, strict=True)
        ],
        halves,
    ),
    Case(
        "Textbook cams",
        "Knife edge in simple harmonic motion",
        "Khurmi and Gupta, *Theory of Machines*, ch. 20 (scene `harmonic-240rpm-radial`)",
        "40 mm in 90° and 60° at 240 rev/min",
        khurmi(("1.00", "1.51"), ("50.6", "113.8")),
        partial(strokes_of, "harmonic-240rpm-radial"),
        "The book takes ω = 25.14 rad/s and angles of four digits: its accelerations are 0.1 % high.",
        LECTURE_NOTES,
    ),
    Case(
        "Textbook cams",
        "Knife edge with uniform acceleration and retardation",
        "Khurmi and Gupta, *Theory of Machines*, ch. 20 (scene `knife-300rpm-radial`)",
        "at 300 rev/min",
        khurmi(("1.88", "1.26"), ("177.7", "79")),
        partial(strokes_of, "knife-300rpm-radial"),
        "Its π and ω have four digits at most.",
        LECTURE_NOTES,
    ),
    Case(
        "Textbook cams",
        "Tangent cam with a roller follower",
        "Khurmi and Gupta, *Theory of Machines*, art. 20.17 (scene `tangent-cam`)",
        "base circle 90 mm, nose radius 10 mm, roller 40 mm, flanks at 90°, 120 rev/min",
        [
            Answer("cam angle on the flank", "28.3", "deg", 0.005),
            Answer("acceleration where the flank ends", "18.4", "m/s²"),
            Answer("deceleration at the top", "20.7", "m/s²"),
        ],
        tangent_cam,
    ),
    Case(
        "Forces and torque",
        "Load on the cam of a spring-loaded follower",
        "Rothbart, *Cam Design Handbook* (2004), Fig. 8.7",
        "a parabolic rise of 1¼ in over 160° at 1200 rev/min, accelerated over 40° of it; 2 lb and a load of 10 lb",
        [
            Answer("acceleration", "20200", "in/s²", 60.0),
            Answer("largest load with the spring", "146", "lb", 1.0),
            Answer("least load with the spring", "7", "lb", 1.0),
            Answer("lacking without the spring", "23", "lb", 0.5),
            Answer("largest load without the spring", "116", "lb", 1.0),
        ],
        loads_on_the_cam,
        "Loads are read in whole pounds from a figure. Speed and spring rate are not in it: they follow from its "
        "accelerations and spring loads. The last load is 104 + 10 + 2 lb.",
    ),
    Case(
        "Forces and torque",
        "When a follower jumps off an eccentric",
        "Shigley and Uicker, *Theory of Machines and Mechanisms*: $\\omega = \\sqrt{(2ke + P)/(me)}$",
        f"m = {MASS:g} kg, k = {RATE:g} N/mm, P = {PRELOAD:g} N, e = {ECCENTRICITY:g} mm; flat face",
        [
            Answer("jump speed", JUMP, "rev/min", 1e-12 * JUMP),
            Answer("least contact force at that speed", 0.0, "N", 1e-9),
        ],
        lambda: (eccentric(300.0)["jump_speed_rpm"], eccentric(JUMP)["contact_force_min_N"]),
    ),
    Case(
        "Forces and torque",
        "Torque of an eccentric",
        "Shigley and Uicker, *Theory of Machines and Mechanisms*: "
        "$T = e(ke + P)\\sin\\omega t + \\frac{1}{2}e^2(m\\omega^2 - k)\\sin 2\\omega t$",
        "the same at 300 rev/min",
        [
            *(
                Answer(name, value, "N·m", 1e-10)
                for name, value in zip(("largest", "least", "root mean square"), torque_in_print(), strict=True)
            ),
            Answer("mean", 0.0, "N·m", 1e-12),
        ],
        lambda: [eccentric(300.0)[f"torque_{name}_N_m"] for name in ("max", "min", "rms", "mean")],
    ),
    Case(
        "Forces and torque",
        "Flywheel of an engine",
        "Khurmi and Gupta, *Theory of Machines*, example 16.1",
        "6.5 t at 1.8 m take up 56 kN·m at 120 rev/min",
        [
            Answer("energy", "56", "kN·m", 56e-9),
            Answer("highest speed", "121", "rev/min"),
            Answer("lowest speed", "119", "rev/min"),
        ],
        flywheel,
    ),
    Case(
        "Contact",
        "Largest shear below a line contact",
        "Budynas and Nisbett, *Shigley's Mechanical Engineering Design* (9th ed.), 3-19",
        "over the largest pressure, and its depth over the half-width",
        [Answer("shear", "0.300"), Answer("depth", "0.786")],
        lambda: (SHEAR_SHARE, SHEAR_DEPTH),
    ),
    Case(
        "Contact",
        "Half-axes of the ellipse of two bodies",
        "Timoshenko and Goodier, *Theory of Elasticity* (3rd ed.), art. 140, by Whittemore and Petrenko (1921)",
        "spherical face of 30 mm on a round cam, 400 N; $m$ and $n$ times $(3P/(4E^*(A + B)))^{1/3}$, "
        "with $\\cos\\theta = (B - A)/(A + B)$",
        [
            Answer(f"${name}$, $\\theta$ = {angle}°", value, "", 3e-3 * float(value))
            for angle, row in ELLIPSES.items()
            for name, value in zip("mn", row, strict=True)
        ],
        ellipses,
        "The table of 1921 is right to 0.3 %, not to its last digit: 0.802 at 70° is 0.7999.",
    ),
    Case(
        "Contact",
        "Sphere on a rigid plane",
        "a benchmark of finite elements, [tutorsglobe.com](https://tutorsglobe.com/question/"
        "a-sphere-of-radius-r--8-mm-is-pressed-against-a-rigid-flat-51707067.aspx)",
        "r = 8 mm, E = 1000 N/mm², ν = 0.3, F = 60π N",
        [Answer("half-width", "1.010", "mm"), Answer("half-length", "1.010", "mm")],
        sphere_on_a_plane,
        read="the page itself",
    ),
    Case(
        "Contact",
        "Ellipticity by a published fit",
        "Hamrock and Dowson, *J. Lubr. Technol.* 99 (1977): $k = 1.03\\,(R_y/R_x)^{0.64}$",
        "for $k$ from 1 to 8",
        [
            Answer(f"$R_y/R_x$ = {ratio:.3g}", float(1.03 * ratio**0.64), "", float(0.032 * 1.03 * ratio**0.64))
            for ratio in FLAT
        ],
        lambda: [float(k) for k in contact_half_axis_ratio(1 / FLAT)],
        "A fit, right to 3 %.",
    ),
    Case(
        "Vibration",
        "Residual amplitude after a step with a sloping front",
        "Ayre in Harris, *Shock and Vibration Handbook*, ch. 8",
        "undamped, of a step of 1, by the time of the front over the natural period",
        [
            Answer(f"{FRONT[law]}, {r:g}", formula(r), "", 1e-10 * formula(r))
            for law, formula in AYRE.items()
            for r in RATIOS
        ],
        partial(residuals, FRONTS),
    ),
    Case(
        "Vibration",
        "Fronts that leave nothing behind",
        "the same chapter",
        "period ratios at which the residual amplitude is zero",
        [Answer(f"{FRONT[law]}, {r:g}", 0.0, "", 1e-13) for law, ratios in STILL.items() for r in ratios],
        partial(residuals, STILL),
    ),
)
