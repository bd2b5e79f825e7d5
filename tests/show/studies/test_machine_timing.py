"""Timing of machines: passages and overlaps against dense samples."""

import numpy as np
import pytest
from support.machines import KNIFE

import camopt
from camopt.core.numerics.turn_curve import TURN
from camopt.scene.machine import Machine
from camopt.solve.machine.stations import resolve_stations


@pytest.mark.parametrize("seed", range(5))
def test_passages_and_overlaps_agree_with_samples(seed):
    rng = np.random.default_rng(seed)
    stations = [
        {"name": f"s{number}", "scene": KNIFE, "phase": rng.uniform(-400, 400), "ratio": int(rng.integers(1, 4))}
        for number in range(3)
    ]
    machine, lift = Machine(station=stations), rng.uniform(1.0, 19.0)
    found = camopt.machine_timing(machine, lift)
    angles = (np.arange(360_000) + 0.5) * TURN / 360_000
    above = {each.name: each.lift.value(angles) > lift for each in resolve_stations(machine)}
    for station in machine.station:
        rows = [each for each in found.passages if each.station == station.name]
        assert len(rows) == station.ratio
        assert sum(each.above_deg for each in rows) == pytest.approx(360.0 * above[station.name].mean(), abs=0.01)
        for row in rows:
            middle = int(row.centre_deg % 360.0 * 1000)
            assert above[station.name][middle % 360_000]
    for pair in found.overlaps:
        both = above[pair.station] & above[pair.other]
        assert pair.overlap_deg == pytest.approx(360.0 * both.mean(), abs=0.01)


def test_lobes_of_a_camshaft_are_as_far_apart_as_their_phases():
    found = {(each.station, each.other): each for each in camopt.machine_timing("camshaft", 1.0).overlaps}
    assert found["exhaust 1", "inlet 1"].separation_deg == pytest.approx(110.0)  # both flanks are symmetric
    assert found["exhaust 1", "exhaust 2"].separation_deg == pytest.approx(180.0)
    assert found["exhaust 1", "exhaust 2"].overlap_deg == 0.0


def test_a_lift_that_a_station_does_not_reach_is_refused():
    with pytest.raises(camopt.BadInput, match="largest lift"):
        camopt.machine_timing("camshaft", 8.7)
