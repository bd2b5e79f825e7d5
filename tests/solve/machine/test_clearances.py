"""Clearances of random machines against dense samples by shapely, and against closed forms."""

import numpy as np
import pytest
from support.machines import random_machine, shapely_distances

from camopt.solve.machine.clearances import clearances_of_machine
from camopt.solve.machine.stations import resolve_stations

RANDOM_MACHINES = 40  # a seed


def distances(machine, stations, angles, shifts=None):
    """Distances of the two outlines of a machine by shapely at angles [deg]."""
    curves, tables = {each.name: each.lift for each in stations}, {}
    for table in (*machine.station, *machine.body):
        tables[table.name] = table
    shifts = shifts or {}
    lifts = [
        curves[name].value(np.radians(angles - shifts.get(name, 0.0))) if name in curves else 0.0 * angles
        for name in ("a", "b")
    ]
    return shapely_distances(tables["a"], tables["b"], *lifts)


@pytest.mark.parametrize("seed", range(5))
def test_least_distances_of_random_machines_are_enclosed(seed):
    rng, gaps, verdicts = np.random.default_rng(seed), [], set()
    for _ in range(RANDOM_MACHINES):
        machine = random_machine(rng)
        stations = resolve_stations(machine)
        (found,) = clearances_of_machine(machine, stations)
        start, end = machine.clear[0].angles
        samples = distances(machine, stations, np.linspace(start, end, 1500))
        assert found.lower <= samples.min() + 1e-10
        (attained,) = distances(machine, stations, np.array([found.angle]))
        assert attained == pytest.approx(found.upper, abs=1e-9)
        assert found.upper <= samples.min() * (1.0 + 1e-9) + 1e-9
        gaps.append((found.upper - found.lower) / max(found.upper, 1.0))
        verdicts.add(found.verdict)
    print(np.sort(gaps)[-8:])
    assert np.quantile(gaps, 0.95) <= 1e-9
