"""Every limit of every mechanism, next to its bound: doubles, ranges, balls and convex steps decide it alike."""

from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support.cams import CONTACTS, FREE, GUIDED, SWUNG, WORN, cam_with, turn_of
from support.depth import is_deep

from camopt import Scene, evaluate
from camopt.core.kernels import compile
from camopt.core.mistakes import BadInput
from camopt.core.numerics import LARGEST, LEAST
from camopt.core.numerics.interval import Interval
from camopt.core.quantities import (
    AT_LEAST,
    DERIVATIVE_UNITS,
    QUANTITIES,
    RMS_ORDERS,
    STROKE_WORDS,
    motion_error_name,
    motion_peak_name,
    motion_rms_name,
)
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.model.effects import EFFECTS, EvaluationBlock, available_quantities
from camopt.model.effects.peak import BodyRadiusPlus
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.limits import Limits
from camopt.scene.problem.constraints import CONSTRAINT_SIDES, ConstantBound, Constraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.limits import LOAD_LIMITS, limited_quantity_name
from camopt.scene.problem.limits import PART_LIMITS as PART_KEYS
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.synthesis import SynthesisSettings
from camopt.solve.smallest.enclosure import (
    enclose_limits,
    size_constraints_with_error_variants,
    size_dependent_mean_constraints,
)
from camopt.solve.synthesis import nonconvex_constraints
from camopt.solve.synthesis.linear_constraints import is_linear
from camopt.solve.synthesis.problem_from_scene import problem_from_settings
from camopt.solve.verdicts.certify import certify_limits
from camopt.solve.verdicts.verdict_words import BROKEN, HELD

NEAR = 1e-9
ELASTIC = {
    "fluctuation": 0.02,
    "natural_frequency": 60.0,
    "damping_ratio": 0.03,
    "lash": 0.3,
    "lash_variation": 0.1,
}
PART = {"thickness": 20, "bore": 30, "keyway_width": 8, "keyway_depth": 3.3, "density": 7800}
GROOVED = {"groove_depth": 8, "bore": 30, "keyway_width": 8, "keyway_depth": 3.3}
"""Without a length: the mass of a grooved cam is not proved."""
RIBBED = {"rib_height": 8, "bore": 30, "keyway_width": 8, "keyway_depth": 3.3}
WITHOUT_SPEED = (
    {
        motion_peak_name(derivative, stroke, angular=angular, timed=False)
        for derivative, stroke, angular in product(DERIVATIVE_UNITS, STROKE_WORDS, (False, True))
    }
    | {
        motion_rms_name(derivative, angular=angular, timed=False)
        for derivative, angular in product(RMS_ORDERS, (False, True))
    }
    | {motion_error_name(order, angular=angular, timed=False) for order, angular in product((1, 2), (False, True))}
)
"""What only a scene without a speed has."""
OTHERWISE = {"pressure_angle_return": {"pressure_angle": 89.0}}
"""What a scene has to say beside a limit, so that it is the limit that decides."""


FOUR_BAR = {
    "stage": "four-bar",
    "crank": 60,
    "coupler": 130,
    "rocker": 75,
    "ground": 140,
    "angle": 70,
    "inertia": 0.01,
}
ROCKER = {
    "stage": "rocker",
    "input_arm": 40,
    "input_angle": -10,
    "output_arm": 55,
    "output_angle": -25,
    "mass": 0.4,
}
WEDGE = {"stage": "incline", "angle": 30, "mass": 0.4}
DRIVING = {
    "roller with a train": ("roller", ROCKER),
    "arm with a train": ("arm", FOUR_BAR),
    "roller with a wedge": ("roller", WEDGE),
}
"""Cams whose followers drive a tool, each with its contact and the one stage of its train."""
PRESSED = {"interference": 0.02, "stiffness": 200_000}  # so that none lets go
PAIRED = {
    "pair": (
        "offset-roller",
        {"kind": "conjugate", "roller_radius": 11, "base_radius": 66, "offset": -7, **PRESSED},
    ),
    "swinging pair": ("arm", {"kind": "conjugate", "roller_radius": 17, "arm_length": 100, **PRESSED}),
    "yoke": ("flat", {"kind": "breadth"}),
    "rib": ("groove", {"kind": "rib", **PRESSED}),
    "swinging rib": ("groove-arm", {"kind": "rib", **PRESSED}),
    "rib of a disc": ("offset-roller", {"kind": "rib", **PRESSED}),
    "swinging rib of a disc": ("arm", {"kind": "rib", **PRESSED}),
}
"""Cams with two contacts of a follower, without a guide, each with the contact and the drive."""
IN_FACE = {"roller in a face": "offset-roller", "arm in a face": "arm"}
"""Discs with a groove in their face, each with its contact."""
CROSSED = {"clearance": 0.02, "roller_inertia": 1e-6, "friction": 0.1}
WITH_MORE = (*DRIVING, *PAIRED)
CAMS = (*CONTACTS, *WITH_MORE, *IN_FACE)


def scene_of(cam, key=None, bound=None):
    """A cam in which every limit of its mechanism can be asked, and one of them is."""
    contact, *train = DRIVING.get(cam, (IN_FACE.get(cam, cam),))
    contact, drive = PAIRED.get(cam, (contact, {}))
    dynamics = (SWUNG if CONTACTS[contact]["motion"] == "oscillating" else FREE if drive else GUIDED) | ELASTIC
    limits = {} if key is None else {**OTHERWISE.get(key, {}), key: bound}
    part = RIBBED if "rib" in cam else GROOVED if contact.startswith("groove") else PART
    more = {"materials": WORN, "limits": limits, "part": part, "outputs": ["sizes"], "train": train, "drive": drive}
    if not drive:
        more["tolerances"] = {"profile": 0.02, "waves": 5, "phase": {"plus": 0.1, "minus": 0.03}}
    if cam in IN_FACE:
        more |= {"drive": {"kind": "groove", **CROSSED}, "part": {**GROOVED, "outer_diameter": 300}}
    if cam == "yoke":
        more["motion"] = turn_of("poly345", 24, (110, 70, 110, 70))
    data = cam_with(contact, "poly345", dynamics, **more)
    if "rib" in cam:
        data["follower"] = data["follower"] | {"roller_spacing": 45}
    return Scene.from_dict(data)


@cache
def limits_of(contact):
    """Every limit that can be asked of a mechanism, by its key, at a bound of 1."""
    keys = dict.fromkeys(Limits.model_fields, 1.0)
    while True:
        try:
            limits = resolve(scene_of(contact).replace(limits=keys)).limits
        except BadInput as error:  # the mechanism has nothing that these are about
            refused = {mistake.key.removeprefix("limits.") for mistake in error.mistakes}
            assert refused & {*keys}
            keys = {key: 1.0 for key in keys if key not in refused}
        else:
            return {limit.name: limit for limit in limits if limit.name in keys}


def unit_limit(contact, key):
    """The limit of a key at a bound of 1, None if the mechanism has nothing that it is about."""
    return limits_of(contact).get(key)


@cache
def quantities(contact):
    """Every quantity of the cam that a limit bounds."""
    limits = [unit_limit(contact, key) for other, key in PAIRS if other == contact]
    return evaluate(
        scene_of(contact).replace(outputs=sorted({name for limit in limits for name in limit.shown_quantities}))
    )


def reached_quantities(contact, key):
    """What the cam reaches of the quantities that a limit bounds."""
    limit, cam = unit_limit(contact, key), quantities(contact)
    values = [cam[name] for name in limit.shown_quantities]
    if limit.name in QUANTITIES:
        return values[0]
    return min(values) if limit.relation == "≥" else max(map(abs, values))


PAIRS = [(contact, key) for contact in CAMS for key in limits_of(contact)]
ENDS = ("held", "broken")
SHORT = {*LIMIT_KEYS}


def sides_of(contact, key):
    """Every limit on both sides in ``.ci/deep``; else of neighbouring mechanisms on one each.

    Two mechanisms are enough there, and four for limits that have a short key.
    """
    having, number = [other for other, name in PAIRS if name == key], list(Limits.model_fields).index(key)
    if is_deep() or len(having) == 1:
        return ENDS
    place = (having.index(contact) + number) % len(having)
    return (ENDS[place % 2],) if place < (4 if key in SHORT else 2) else ()


CASES = [(contact, key, side) for contact, key in PAIRS for side in sides_of(contact, key)]


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Single designs, of so many problems that their kernels would be compiled."""
    monkeypatch.setattr(compile, "COMPILATION", np.inf)


def test_every_limit_is_met_on_some_mechanism():
    assert {key for _, key in PAIRS} == {*Limits.model_fields} - WITHOUT_SPEED
    assert {contact for contact, _ in PAIRS} == {*CAMS}
    many = {key for key in Limits.model_fields if sum(key == other for _, other in PAIRS) > 1}
    assert {(key, side) for _, key, side in CASES} >= {*product(many, ENDS)}


def in_doubles(scene, key):
    return key in evaluate(scene)["violated"].split(",")


def in_balls(problem, key):
    verdict = certify_limits(problem, problem.design)[key]
    assert verdict in (HELD, BROKEN)
    return verdict == BROKEN


def in_ranges(problem):
    """Of a box without width."""
    sizes = {name: Interval(value, value) for name, value in problem.design.sizes.items()}
    box = problem.design.with_values(sizes)
    found = enclose_limits(
        problem,
        [*size_constraints_with_error_variants(problem), *size_dependent_mean_constraints(problem)],
        box,
        ["size"],
    )
    assert bool(found.empty[0]) != bool(found.within_rounding[0])
    return bool(found.empty[0])


@dataclass(frozen=True, eq=False)
class Bent(Limit):
    """A limit that says one thing of a curve."""

    constraint: Constraint = None

    def excess(self, columns, designs):
        return np.zeros(len(designs))

    @property
    def constraints(self):
        return (self.constraint,)


@pytest.mark.parametrize("side", ENDS)
@pytest.mark.parametrize("goal", CONSTRAINT_SIDES)
def test_a_factor_counts_for_every_goal(goal, side, monkeypatch):
    """A bound on κ·(R_r + 3 mm), above and below: the profile of this cam has concave flanks."""
    problem = with_rounding_relative_error(resolve(scene_of("roller")))
    constraint = Constraint(
        problem.setup.mechanism.curvature, ALL_STROKES, goal, ConstantBound(1.0), BodyRadiusPlus(3.0)
    )
    extreme = (
        EvaluationBlock(problem.setup, problem.programme, problem.design)
        .extremes(constraint.curve, [(ALL_STROKES, goal)])
        .value
    )
    value = (extreme[0] * constraint.factor(problem.design)).item()
    outwards = 1.0 if (side == "held") == (goal != LEAST) else -1.0
    constraint = constraint._replace(bound=ConstantBound(value + outwards * NEAR * abs(value)))
    problem = replace(
        problem, limits=(Bent("bent", constraint.bound.number, problem.setup, constraint=constraint),)
    )
    assert in_balls(problem, "bent") == in_ranges(problem) == (side == "broken")
    assert in_planes(problem, "bent", monkeypatch) == (side == "broken")


@pytest.mark.parametrize("contact", CAMS)
def test_no_factor_is_below_zero(contact):
    design = resolve(scene_of(contact)).design
    for constraint in (each for limit in limits_of(contact).values() for each in limit.constraints):
        assert np.all(np.asarray(constraint.factor(design)) >= 0.0)


def test_only_constraints_with_one_kind_of_factor_are_compared():
    curve = resolve(scene_of("roller")).setup.mechanism.curvature
    wide, narrow = (
        Constraint(curve, ALL_STROKES, LARGEST, ConstantBound(1.0), BodyRadiusPlus(radius)) for radius in (2.0, 5.0)
    )
    plain = Constraint(curve, ALL_STROKES, LARGEST, ConstantBound(0.1))
    assert wide.comparison_key == narrow.comparison_key != plain.comparison_key
    assert narrow.strictness > wide.strictness
    assert wide._replace(bound=ConstantBound(2.0)).comparison_key != wide.comparison_key


def worst_angles(problem, constraint):
    """Just before and after where each side of a constraint is worst."""
    case = EvaluationBlock(problem.setup, problem.programme, problem.design)
    goals = [(constraint.kinds, LARGEST if side > 0.0 else LEAST) for side in constraint.side_signs]
    return problem.programme.one_sided_angles(
        case.extremes(constraint.curve, goals).where, constraint.kinds
    ).ravel()


def sizes_of(synthesis_problem):
    """The lead and the height of the problem's own design."""
    problem, design = synthesis_problem.scene_problem, synthesis_problem.scene_problem.design
    height = (
        problem.setup.mechanism.start(design)
        if synthesis_problem.has_lead_in_prime_radius
        else design.size + synthesis_problem.prime_less_cam_radius
    )
    return float(design.signed_offset[0]), float(height[0])


def over_samples(synthesis_problem, constraint, monkeypatch):
    """By how much the curves of convex steps are over their bounds; samples are the worst cam angles."""
    angles, programme = (
        worst_angles(synthesis_problem.scene_problem, constraint),
        synthesis_problem.scene_problem.programme,
    )
    for stroke in synthesis_problem.strokes:
        x = (angles - stroke.start) / stroke.angle
        x = x[(x >= 0.0) & (x <= 1.0)]
        if not x.size:
            continue
        monkeypatch.setattr(nonconvex_constraints, "stroke_sample_positions", lambda *_, at=x: at)
        state = programme.motion_at(stroke.start + stroke.angle * x)
        yield from (
            nonconvex_constraints.SampledConstraints(synthesis_problem, stroke)
            .ratios_to_bounds([constraint], state, sizes_of(synthesis_problem))
            .ravel()
            - 1.0
        )


def below_planes(synthesis_problem, name):
    """By how much the motion and the sizes are below a linear limit, at the worst cam angle of each stroke."""
    lead, height = sizes_of(synthesis_problem)
    for floor in (each for each in synthesis_problem.linear_constraints if each.name == name):

        def over(angle, f=floor):
            y, y1, y2, _ = synthesis_problem.scene_problem.programme.motion_at(np.atleast_1d(angle))
            moved = f.displacement * y + f.velocity * y1 + f.acceleration * y2
            return np.squeeze(moved + f.lead * lead + f.height * height + f.constant)

        for stroke in (each for each in synthesis_problem.strokes if each.kind & floor.kinds):
            angles = np.linspace(stroke.start, stroke.start + stroke.angle, 2001)[:-1]
            k = int(np.clip(np.argmin(over(angles)), 1, angles.size - 2))
            near = minimize_scalar(over, bounds=(angles[k - 1], angles[k + 1]), options={"xatol": 1e-9})
            yield -min(near.fun, over(angles).min())


def in_planes(problem, key, monkeypatch):
    """Over the samples of convex steps, or below the linear limits."""
    synthesis_problem = problem_from_settings(problem, SynthesisSettings())
    limit = next(each for each in problem.limits if each.name == key)
    over = [
        v
        for c in limit.constraints
        if not is_linear(problem, c)
        for v in over_samples(synthesis_problem, c, monkeypatch)
    ]
    return any(excess > 0.0 for excess in (*over, *below_planes(synthesis_problem, key)))


@pytest.mark.one_in(45)
@pytest.mark.parametrize(("contact", "key", "side"), CASES)
def test_a_limit_is_decided_alike_on_either_side_of_its_bound(contact, key, side, monkeypatch):
    limit, value = unit_limit(contact, key), reached_quantities(contact, key)
    outwards = -1.0 if limit.relation == "≥" else 1.0
    eased = outwards if side == "held" else -outwards
    near = np.isfinite(value) and value != 0.0  # a film of 0 and an infinite stress break any limit
    bound = value + eased * NEAR * abs(value) if near else 1.0
    scene, broken = scene_of(contact, key, bound), outwards * (value - bound) > 0.0
    assert broken == (side == "broken") or not near
    problem = with_rounding_relative_error(resolve(scene))
    problem = replace(problem, limits=tuple(each for each in problem.limits if each.name == key))
    assert in_doubles(scene, key) == broken
    assert in_balls(problem, key) == broken
    if limit.mean_constraint is not None and not limit.is_decided_by_motion_alone:
        assert in_ranges(problem) == broken
    elif limit.constraints and not limit.is_decided_by_motion_alone:
        assert in_ranges(problem) == broken
        # free laws drive no tool, and no second contact
        assert contact in WITH_MORE or in_planes(problem, key, monkeypatch) == broken
    elif limit.least_contact_force is not None and contact not in WITH_MORE:
        assert in_planes(problem, key, monkeypatch) == broken


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["roller", "arm"])
def test_bounds_on_derivatives_by_the_cam_angle_need_no_speed(contact):
    still = Scene.from_dict(cam_with(contact, "poly345")).replace(**{"cam.rpm": None, "search": None})
    cam = evaluate(still)
    names = WITHOUT_SPEED & {*cam}
    assert len(names) == len(DERIVATIVE_UNITS) * (len(STROKE_WORDS) - 1) + len(RMS_ORDERS)
    for name in names:
        for share in (1 + NEAR, 1 - NEAR):
            scene = still.replace(limits={name: cam[name] * share})
            problem = resolve(scene)
            assert certify_limits(problem, problem.design)[name] == (HELD if share > 1 else BROKEN)
            assert evaluate(scene)["feasible"] == (share > 1)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CAMS)
def test_a_short_key_and_the_name_of_its_quantity_say_the_same(contact):
    limits = limits_of(contact)
    for key in limits.keys() & {*LOAD_LIMITS, *PART_KEYS}:
        short, long = limits[key], limits[limited_quantity_name(key, resolve(scene_of(contact)).setup)]
        assert [c._replace(curve=None) for c in short.constraints] == [
            c._replace(curve=None) for c in long.constraints
        ]
        same = (
            short.required_quantities,
            short.shown_quantities,
            short.relation,
            short.least_contact_force,
            short.least_size,
            short.most_size,
        )
        assert same == (
            long.required_quantities,
            long.shown_quantities,
            long.relation,
            long.least_contact_force,
            long.least_size,
            long.most_size,
        )


@pytest.mark.parametrize("contact", CAMS)
def test_every_quantity_that_is_a_peak_or_a_mean_is_limited_here(contact):
    setup = resolve(scene_of(contact)).setup
    names = {name for effect in EFFECTS.values() for name in (*effect.peaks(setup), *effect.means(setup))}
    names &= {name for name in available_quantities(setup) if QUANTITIES[name].relation_to_limit}
    assert len(names) > 20
    assert names <= {limited_quantity_name(key, setup) for key in limits_of(contact)}
    decided = {
        name for name in names if limits_of(contact)[name].constraints or limits_of(contact)[name].mean_constraint
    }
    assert decided == names


@pytest.mark.parametrize("contact", CAMS)
def test_every_peak_is_bounded_from_the_side_that_its_list_says(contact):
    setup = resolve(scene_of(contact)).setup
    for effect in EFFECTS.values():
        for name, peak in effect.peaks(setup).items():
            if QUANTITIES[name].relation_to_limit:
                assert peak.is_least == (QUANTITIES[name].relation_to_limit == AT_LEAST), name
