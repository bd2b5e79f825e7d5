"""The output of ``camopt fit``."""

from typing import TYPE_CHECKING

from camopt.cli.terminal import print_json, show
from camopt.problem.rows import finite
from camopt.quantities import QUANTITIES
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.tables.cells import number, with_unit
from camopt.tables.layout import table_of

if TYPE_CHECKING:
    from camopt.measured.fitted import Fit


def show_fit(result: "Fit", as_json: bool) -> None:
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


def _show_profile(result: "Fit") -> None:
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
