"""The output of ``camopt evaluate``."""

from math import degrees
from typing import TYPE_CHECKING

import camopt
from camopt.cli.terminal import print_json, room_across, show
from camopt.problem.problem import resolve, resolve_design
from camopt.quantities import displacement_unit
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.scene.read import numbers_read
from camopt.scene.speed import TURNS_OF_CRANK
from camopt.tables.cells import number, with_unit
from camopt.tables.layout import table_of
from camopt.verdicts.warned import farthest
from camopt.verdicts.words import ARM_UNCHECKED

if TYPE_CHECKING:
    from camopt.scene.read import Read


def show_evaluation(result: "camopt.Evaluation", as_json: bool) -> None:
    """Every quantity of a design, one a line."""
    if as_json:
        return print_json(result.to_json())
    show(result.table(explained=room_across() >= ROOM_TO_EXPLAIN), _highest(result.scene))
    if tightest := result.tightest:
        show(f"Tightest of both contacts: {tightest}.")
    if lost := _lost(result.scene):
        show(lost)
    if result.scene.mechanism.motion.angular:
        show(f"{ARM_UNCHECKED}.")
    if joints := [
        {name: "" if v is None else v for name, v in each._asdict().items()} for each in result.joint_forces
    ]:
        show("", table_of(JOINTS, joints, joints[0]), JOINTS_SAY)
    if read := numbers_read(result.scene):
        rows = [{"key": each.key, "value": as_read(each), "unit": shown_unit(each.unit)} for each in read]
        show("", table_of("Numbers of the scene, as they are read", rows, ["key", "value", "unit"]))
        if result.scene.by_crank:
            show(_of_crank(result))
    return None


def _highest(scene: "camopt.Scene") -> str:
    """The largest lift, and where it is."""
    programme, unit = resolve(scene).programme.tool, displacement_unit(angular=scene.tool_turns)
    angle = degrees(farthest(programme, 1.0).angle)
    whose, lift = " of the tool" if scene.train else "", with_unit(programme.lift / programme.unit, unit)
    return f"Largest lift{whose}: {lift}, reached at {number(angle)}°."


def _lost(scene: "camopt.Scene") -> str:
    """Whether cams within the tolerances have no preload between two contacts."""
    if not scene.mechanism.further or not scene.drive.interference:
        return ""
    from camopt.tolerances.held import preload_lost

    return preload_lost(scene, resolve_design(scene))


def _of_crank(result: "camopt.Evaluation") -> str:
    """What speeds are in the results of a scene that gives that of a crankshaft."""
    what = "Results are at the speed of the cam, and speeds among them are the cam's, half those of the crankshaft"
    jump = result.get("jump_speed_rpm")
    return what + ("." if jump is None else f": a jump speed of {number(TURNS_OF_CRANK * jump)} rev/min there.")


def as_read(read: "Read") -> str:
    """A number of the scene, as it is shown; of a load that changes, how many rows it has."""
    value = read.value
    return number(shown(value, read.unit)) if isinstance(value, float) else f"{len(value):,} rows"


JOINTS = "Forces in the joints of the train over the turn"
JOINTS_SAY = (
    "Above 0 a coupler is pushed and a roller pressed on its face, below 0 pulled and lifted off. On a pivot: the "
    "sum of the magnitudes of both forces on it, the largest that it can be. Directions, of the largest, are from "
    "the motion of the slide, those of a four-bar's coupler from the line of its pivots."
)
ROOM_TO_EXPLAIN = 110  # columns of a screen: on a narrower one each sentence would be a column of single words
