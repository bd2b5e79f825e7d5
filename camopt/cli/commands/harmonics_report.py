"""The output of ``camopt harmonics``."""

import camopt
from camopt.cli.terminal import print_json, show
from camopt.problem.rows import finite


def show_harmonics(result: camopt.Harmonics, as_json: bool) -> None:
    """The amplitude and the phase of each harmonic."""
    if as_json:
        about = {"scene": result.scene.name, "mean": result.mean, "acceleration_unit": result.acceleration_unit}
        return print_json({**about, "harmonics": [finite(each) for each in result.records()]})
    return show(result.table())
