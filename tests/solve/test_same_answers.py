"""Searches give the same answer on every machine: none reads the clock, unless a user gives a time."""

import json
import random
import sys
import time
from pathlib import Path

import pytest

import camopt
from camopt.solve.smallest import optimise as smallest
from camopt.solve.tolerances import allocation, dwells_and_passages, worst_case

PACKAGE = Path(camopt.__file__).parent
CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
READERS = {
    "cli/commands/searches.py": "the seconds of a user",
    "cli/interrupts.py": "signals that a terminal sends twice",
    "core/engines/dask_cluster.py": "the number of designs in a task of a cluster",
    "core/engines/processes.py": "whether other processes start: which of them works changes no answer",
    "core/numerics/budget.py": "the seconds of a user",
    "core/numerics/clock.py": "tables of times",
    "core/kernels/kernel_cache.py": "ages of folders",
    "core/storage/files.py": "ages of files",
    "solve/front/estimate.py": "a note on the time of a sweep",
    "solve/front/store.py": "how often files are written",
    "solve/synthesis/frontier.py": "a note on the time of a frontier",
}
"""All modules that read a clock, and for what."""
ROLLER = {
    "cam.rpm": 600,
    "follower.dynamics": {"mass": 1.0, "preload": 800.0, "spring_rate": 20.0},
    "materials": {"cam": "steel", "follower": "steel", "face_width": 10.0},
    "limits": {"contact_stress": 620, "pressure_angle": 35},
}
ANGLES = {"angle_rise": {"start": 100, "stop": 140}, "angle_return": {"start": 80, "stop": 120}}
SIZES = {"offset": {"start": -20, "stop": 20}, "roller_radius": {"start": 5, "stop": 20}}


def roller(**search):
    """A scene whose contact stress decides."""
    return camopt.find_scene("roller-1000rpm").replace(**ROLLER, search={"law": ["poly345"], **search})


def lever():
    """A scene whose lever has free arms."""
    arms = {"base_radius": {"start": 10, "stop": 80}, "train": {"1": {"ratio": {"start": 1.5, "stop": 2.5}}}}
    return camopt.find_scene("pusher-by-lever").replace(search=arms)


def tolerances(name):
    """A scene with tolerances."""
    return camopt.find_scene(name).replace(tolerances={"profile": 0.02, "phase": 0.05})


SEARCHES = {
    "angles": lambda: camopt.optimise(roller(**ANGLES, **SIZES)),
    "sizes": lambda: camopt.optimise(roller(**SIZES)),
    "train": lambda: camopt.optimise(lever()),
    "prices": lambda: camopt.prices(camopt.optimise(roller(**SIZES))),
    "tolerance": lambda: camopt.tolerance(tolerances("bucket-valve")),
    "timing": lambda: camopt.timing(tolerances("bucket-valve"), [1.0]),
    "allocate": lambda: camopt.allocate(tolerances("valve-rod-offset"), 0.2),
}


@pytest.fixture
def wild_clocks(monkeypatch):
    """Clocks that leap by up to an hour at each reading, for all modules of camopt."""
    leaps, now = random.Random(1), [0.0]

    def leap():
        now[0] += leaps.choice((0.0, 1e-3, 60.0, 3600.0))
        return now[0]

    def set_clocks():
        for name, module in [*sys.modules.items()]:
            for clock in CLOCKS if name.startswith("camopt") else ():
                if getattr(module, clock, None) is getattr(time, clock):
                    monkeypatch.setattr(module, clock, leap)

    return set_clocks


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "share"),
    [*((name, 3e-3) for name in SEARCHES), *((name, 1.0) for name in ("sizes", "train", "timing"))],
)
def test_no_clock_changes_an_answer(monkeypatch, wild_clocks, name, share):
    """With the default work, and with so little that some searches stop early."""
    for module in (smallest, allocation, dwells_and_passages, worst_case):
        for constant in [each for each in vars(module) if each.endswith("_WORK") and share < 1.0]:
            monkeypatch.setattr(module, constant, share * getattr(module, constant))
    answers = []
    for set_clocks in (lambda: None, wild_clocks):
        set_clocks()
        answers.append(json.dumps(SEARCHES[name]().values_for_json(), sort_keys=True))
    assert answers[0] == answers[1]


def test_little_work_stops_a_search_before_its_proof_with_a_cam(monkeypatch):
    monkeypatch.setattr(smallest, "OPTIMISE_WORK", 1e6)
    found = camopt.optimise(roller(**ANGLES, **SIZES))
    assert found.out_of_time
    assert found.best is not None
    assert not found.best["proved"]


def test_each_reader_of_a_clock_has_its_reason():
    readers = {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if any(line.startswith(("from time import", "import time")) for line in path.read_text().splitlines())
    }
    assert readers == set(READERS)
