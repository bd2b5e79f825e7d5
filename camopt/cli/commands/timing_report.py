"""The output of ``camopt timing``."""

import camopt
from camopt.cli.terminal import print_json, show
from camopt.problem.rows import finite


def show_timing(result: camopt.Timing, as_json: bool) -> None:
    """The cam angles at which lifts are passed, and those of the worst cams."""
    if as_json:
        about = {"scene": result.scene.name, "velocity_unit": result.velocity_unit}
        worst = [finite(each._asdict()) for each in result.worst]
        return print_json({**about, "passages": [finite(each) for each in result.records()], "worst": worst})
    return show(*filter(None, (result.table(), result.worst_table())))
