"""The cams of ``camopt tolerance`` on disk: the worst ones, a batch, and one with chosen grades."""

from camopt.drawing.plot import plot
from camopt.scene.written import write_scene
from camopt.storage.publishing import Publication
from camopt.tolerances.tolerance import MotionErrors
from camopt.tolerances.turn import NAMES

WORST, ALLOCATED, CAMS, HISTOGRAM = "worst-{}.toml", "allocated.toml", "cams.parquet", "cams.svg"
CAM_FILES = (WORST.format("*"), ALLOCATED, CAMS, HISTOGRAM)
"""The scenes of the worst motions, of the worst cam of each limit and of the grades; what each cam of a batch has,
and its picture."""


def write_cams(result: MotionErrors, unit: Publication) -> None:
    """Write the cams with the worst motions, that of each limit, the one with allocated tolerances, and a batch."""
    motions = dict(zip(NAMES, ("motion", "motion-velocity", "motion-acceleration"), strict=True))
    for (name, file), each in zip(motions.items(), result.worst_cases, strict=True):
        if each.errors:
            write_scene(unit.path(WORST.format(file)), result.worst_motion(name))
    for margin in result.margins:
        if margin.quantity and margin.worst != margin.nominal:
            write_scene(unit.path(WORST.format(margin.limit)), result.worst_cam(margin.limit))
    if result.allocation:
        write_scene(unit.path(ALLOCATED), result.allocation.scene)
    if result.batch:
        result.batch.write(unit.path(CAMS))
        plot(result.batch, unit.path(HISTOGRAM))
