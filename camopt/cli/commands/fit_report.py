"""The output of ``camopt fit``."""

from pathlib import Path
from typing import Any

import camopt
from camopt.cli.options import changed
from camopt.cli.terminal import print_json, show
from camopt.mechanisms.body import DISC
from camopt.mechanisms.follower import FLAT, ROLLER, TRANSLATING
from camopt.mistakes import BadInput, Mistake
from camopt.problem.rows import finite
from camopt.quantities import QUANTITIES
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.scene.written import write_scene
from camopt.tables.cells import number, with_unit
from camopt.tables.layout import table_of


def measured_cam(
    target: str | None,
    rpm: float | None,
    base_radius: float | None,
    follower: str | None,
    roller_radius: float | None,
    profile: str | None,
) -> Any:
    """The cam and follower of a measured motion: a scene, or its tables from options alone."""
    if profile and base_radius is not None:
        why = "belongs to lifts: the profile itself has a base radius"
        raise BadInput([Mistake("camopt", "--base-radius", base_radius, why, bare=True)])
    if target is None:
        if base_radius is None and not profile:
            raise BadInput([Mistake("camopt", "--base-radius", None, "missing; or name a --scene", bare=True)])
        if follower == ROLLER.name and roller_radius is None:
            raise BadInput([Mistake("camopt", "--roller-radius", None, "missing; a roller has one", bare=True)])
        sizes = {} if roller_radius is None else {"roller_radius": roller_radius}
        known = {"base_radius": base_radius, "rpm": rpm}
        cam = {"form": DISC.form, **{key: value for key, value in known.items() if value is not None}}
        return {"cam": cam, "follower": {"motion": TRANSLATING.name, "contact": follower or FLAT.name, **sizes}}
    why = "belongs to a fit without --scene: the scene has a follower"
    others = {"--follower": follower, "--roller-radius": roller_radius}
    given = [Mistake("camopt", name, value, why, bare=True) for name, value in others.items() if value is not None]
    if given:
        raise BadInput(given)
    changes = {"cam.rpm": ("--rpm", rpm), "cam.base_radius": ("--base-radius", base_radius)}
    scene = camopt.find_scene(target)
    return changed(scene, {key: change for key, change in changes.items() if change[1] is not None})


def write_fit(result: "camopt.Fit", out: Path, picture: Path | None) -> list[Path]:
    """Write the scene of a fit, and its picture if that is asked for; the files."""
    write_scene(out, result.scene)
    if picture is None:
        return [out]
    camopt.plot(result, picture)
    return [out, picture]


def show_fit(result: "camopt.Fit", as_json: bool) -> None:
    """Deviations of the motion from the points, its segments, and its peaks beside those of plain differences."""
    if as_json:
        found = result.to_dict()
        return print_json(found | {name: finite(found[name]) for name in ("before", "after")})
    unit, away = result.unit, result.deviation
    lowest = f"its lowest {'position' if result.profile else 'lift'} is {with_unit(result.zero, unit)}"
    count = f"{result.points.angles.size:,} points, noise {with_unit(result.noise, unit)}"
    times = f" ({result.band / result.noise:.3g} times the noise)" if result.usual else ""
    off = f"at most {with_unit(away.largest, unit)} away, root mean square {with_unit(result.deviation_rms, unit)}"
    show(
        f"{result.scene.name}: {count}",
        f"Band {with_unit(result.band, unit)}{times}, proved at every point: {off}.",
        f"From the straight lines between points it is nowhere further than {with_unit(away.between, unit)}.",
        f"The turn starts at the measured angle {result.start:g} deg; {lowest}.",
    )
    if result.scene.train:
        whose, other = ("follower", "tool") if result.at_follower else ("tool", "follower")
        show(f"The lift is that of the {whose}; the train of the scene gives the motion of the {other}.")
    if result.profile is not None:
        _show_profile(result)
    segments = [{"law": "", **segment.model_dump(exclude_none=True)} for segment in result.scene.motion]
    show(
        "",
        table_of("The motion", segments, ["segment", "angle", "lift", "law"], units={"angle": "deg", "lift": unit}),
    )
    before = result.before
    peaks = [
        {
            "largest": name,
            "by differences": shown(before[name], unit),
            "of the motion": shown(value, unit),
            "unit": shown_unit(unit),
        }
        for name, value in result.after.items()
        for unit in [QUANTITIES[result.quantity(name)].unit]
    ]
    show(table_of("Before and after", peaks, ["largest", "by differences", "of the motion", "unit"]))
    jerk = QUANTITIES[result.quantity("jerk")].unit
    what = f"Root mean square of the jerk: {with_unit(result.jerk_rms, jerk)}"
    least = number(shown(result.least_jerk_rms, jerk))
    return show(f"{what}; no motion as near to the points has less than {least}.")


def _show_profile(result: "camopt.Fit") -> None:
    """What a profile was measured with, whose lift it gives, and how far its points are from the cam found."""
    assert result.profile is not None
    follower, found = result.scene.follower, result.to_dict()["profile"]
    numbers = {key: with_unit(found[f"{key}_mm"], "mm") for key in ("base_radius", "distance_max", "distance_rms")}
    radius = with_unit(result.profile.probe, "mm")
    probe = f"centres of a ball of {radius}" if result.profile.probe else "points on the profile itself"
    off = f"{numbers['distance_max']}, root mean square {numbers['distance_rms']}"
    show(
        f"Measured: {probe}; the lift is that of the follower: {follower.motion}, {follower.contact}.",
        f"Base radius {numbers['base_radius']}. From the profile of this cam the points are at most {off}.",
    )
