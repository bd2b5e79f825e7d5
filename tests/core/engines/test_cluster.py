"""A Dask cluster of processes: results as those of threads, whatever happens to workers and to the scheduler."""

import os
import signal
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from socket import socket
from time import sleep

import numpy as np
import psutil
import pytest
import scipy
from distributed import CancelledError
from distributed.comm.core import CommClosedError

import camopt
from camopt.cli import exits
from camopt.cli.main import main
from camopt.core.engines import cluster, dask_cluster
from camopt.core.mistakes import BadInput
from camopt.solve.front import store


@pytest.fixture(scope="module")
def engine():
    """Two workers that are processes of this machine."""
    with cluster("local", 2) as engine:
        yield engine


def sines(items: Sequence[int]) -> list[float]:
    """What differs in its last bit as soon as something is not as here."""
    return np.sin(np.array(items, dtype=float)).tolist()


def sines_or_death(folder: Path, deadly: Sequence[int], items: Sequence[int]) -> list[float]:
    """The same, but some items kill the worker that has them first."""
    for item in {*items} & {*deadly}:
        try:
            (folder / str(item)).touch(exist_ok=False)
        except FileExistsError:
            continue
        os.kill(os.getpid(), signal.SIGKILL)
    return sines(items)


def death(items: Sequence[int]) -> None:
    """What no worker survives."""
    os.kill(os.getpid(), signal.SIGKILL)


def write_item_files(folder: Path, items: Sequence[int]) -> int:
    """Has a file for each item that was done."""
    (folder / str(items[0])).touch()
    return items[0]


def bytes_of(size: int, items: Sequence[int]) -> bytes:
    return size * b" "


def fault(items: Sequence[int]) -> None:
    raise ZeroDivisionError(f"of item {items[0]}")


def allow_failures(engine, number):
    """Set how many workers may die of a task until it is given up; the number before."""

    def change(dask_scheduler):
        before, dask_scheduler.allowed_failures = dask_scheduler.allowed_failures, number
        return before

    return engine.client.run_on_scheduler(change)


def flat(parts):
    return [value for part in parts for value in part]


@pytest.mark.slow
def test_results_come_in_order_and_are_those_of_this_process(engine):
    items = range(1000)
    assert flat(engine.results_in_order(sines, items, sample=items[:3])) == sines(items)


def test_without_items_there_is_nothing_to_do(engine):
    assert list(engine.results_in_order(sines, [])) == []


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_no_result(engine, tmp_path):
    items, deadly = range(60), [5, 33]
    work = partial(sines_or_death, tmp_path, deadly)
    assert flat(engine.results_in_order(work, items)) == sines(items)
    assert {int(path.name) for path in tmp_path.iterdir()} == {*deadly}


async def no_workers(dask_scheduler):
    """All workers are closed, and none comes back."""
    for address in [*dask_scheduler.workers]:
        await dask_scheduler.remove_worker(address, stimulus_id="test", close=True)


@pytest.mark.slow
def test_nobody_waits_for_workers_that_are_all_gone(monkeypatch):
    with cluster("local", 1) as engine:
        found = engine.results_in_order(sines, range(10_000))
        next(found)
        monkeypatch.setattr(dask_cluster, "WORKER_SECONDS", 1.0)
        engine.client.run_on_scheduler(no_workers)
        with pytest.raises(ConnectionError, match="the Dask scheduler has no workers"):
            list(found)


def test_what_fails_in_a_worker_fails_here(engine):
    with pytest.raises(ZeroDivisionError, match="of item"):
        list(engine.results_in_order(fault, range(3)))


@pytest.mark.parametrize("share", ["camopt 1.2.3", "numpy 1.2.3"])
def test_a_worker_with_other_versions_is_refused(engine, monkeypatch, share):
    own, other = dask_cluster.versions_of_camopt_numpy_and_scipy(), f"{share}, and more"
    monkeypatch.setattr(dask_cluster, "versions_of_camopt_numpy_and_scipy", lambda: other)
    with pytest.raises(BadInput) as refusal:
        list(engine.results_in_order(sines, range(3)))
    (line,) = str(refusal.value).splitlines()
    worker, why = line.removeprefix("camopt: scheduler = 'tcp://127.0.0.1:").split("': ")
    assert worker.isdecimal()
    assert why == f"must be a worker with the same versions as this machine, {other}; it has {own}"


def test_the_versions_are_all_on_which_a_result_depends(monkeypatch):
    own = dask_cluster.versions_of_camopt_numpy_and_scipy()
    for package in (np, scipy):
        with monkeypatch.context() as patch:
            patch.setattr(package, "__version__", "1.2.3")
            assert dask_cluster.versions_of_camopt_numpy_and_scipy() != own
    monkeypatch.setattr(
        dask_cluster, "camopt_and_kernel_version", lambda: "1.2.3"
    )  # camopt, kernels, numba and Python
    assert dask_cluster.versions_of_camopt_numpy_and_scipy() != own


def test_few_results_wait_to_be_read(engine, tmp_path):
    work = partial(write_item_files, tmp_path)
    found = engine.results_in_order(work, range(1000))
    assert [next(found) for _ in range(3)] == [0, 1, 2]
    sleep(0.3)
    assert len([*tmp_path.iterdir()]) <= 3 + dask_cluster.TASKS_AHEAD * engine.workers
    found.close()


def test_a_task_that_ends_every_worker_is_given_up(engine):
    patient = allow_failures(engine, 0)
    with pytest.raises(ChildProcessError, match="one task killed every worker that tried it"):
        list(engine.results_in_order(death, range(1)))
    allow_failures(engine, patient)


def test_a_reader_that_stops_leaves_nothing_behind(engine):
    found = engine.results_in_order(sines, range(10_000))
    next(found)
    found.close()
    assert flat(engine.results_in_order(sines, range(10))) == sines(range(10))


SCENE = camopt.find_scene("roller-1000rpm").replace(
    search={
        "base_radius": {"start": 30, "stop": 149, "step": 1},
        "offset": {"start": 0, "stop": 18, "step": 2},
        "law": ["harmonic", "cycloidal"],
    }
)


def files(swept):
    return {file.name: file.read_bytes() for file in swept.files}


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("keep", ["feasible", "all", "pareto"])
def test_a_sweep_writes_the_files_of_one_thread_though_a_worker_is_killed(engine, keep, tmp_path):
    victims = list(engine.client.run(os.getpid).values())[:1]

    def kill(done, total):
        while victims:
            os.kill(victims.pop(), signal.SIGKILL)

    one = camopt.sweep(SCENE, tmp_path / "one", keep=keep, workers=1)
    many = camopt.sweep(SCENE, tmp_path / "many", keep=keep, progress=kill, block=100, engine=engine)
    assert not victims
    assert files(many) == files(one)
    assert {**vars(many), "files": ()} == {**vars(one), "files": ()}


@pytest.mark.slow
def test_a_sweep_that_is_stopped_goes_on_without_the_cluster_and_with_it(engine, tmp_path, monkeypatch):
    monkeypatch.setattr(store, "SAVE_SECONDS", 0.0)
    one = camopt.sweep(SCENE, tmp_path / "one", block=100, workers=1)
    for share, used in ((0.3, engine), (0.6, None)):
        with pytest.raises(camopt.Stopped, match="designs are done and kept"):
            camopt.sweep(
                SCENE,
                tmp_path / "two",
                progress=lambda done, total, share=share: done < share * total,
                block=100,
                engine=used,
            )
    assert files(camopt.sweep(SCENE, tmp_path / "two", block=100, engine=engine)) == files(one)


@pytest.mark.slow
def test_a_local_cluster_is_for_this_machine_alone_and_may_be_one_of_several(engine):
    with cluster("local", 1) as one:
        connections = [each for each in psutil.Process().net_connections() if each.status == psutil.CONN_LISTEN]
        one.client.wait_for_workers(1)
        assert one.workers == 1
    assert connections
    with pytest.raises(ConnectionError, match="was lost or restarted"):
        list(one.results_in_order(sines, range(3)))
    with pytest.raises(ConnectionError, match="was lost or restarted"):
        one.workers  # noqa: B018
    assert {each.laddr.ip for each in connections} == {"127.0.0.1"}


class Bereaved:
    """A client whose scheduler dies just after it connected."""

    status = "running"

    def nthreads(self):
        return {"tcp://10.0.0.2:40000": 1}

    def submit(self, *arguments, pure):
        self.status = "connecting"
        raise OSError("Timed out trying to connect to tcp://10.0.0.1:8786 after 20 s")


class BereavedLater(Bereaved):
    """A client whose scheduler dies while tasks are under way."""

    def submit(self, *arguments, pure):
        return self

    def result(self, timeout=None):
        self.status = "connecting"
        raise CancelledError("scheduler-connection-lost")


class Unaware(Bereaved):
    """A client that does not know yet that its scheduler died: its status is still ``running``."""

    loss = CommClosedError("in <TCP (closed) ConnectionPool.gather>: ConnectionResetError")

    def submit(self, *arguments, pure):
        return self

    def result(self, timeout=None):
        raise self.loss


class UnawareAtStart(Unaware):
    """One that loses its scheduler before the first task."""

    def nthreads(self):
        raise self.loss


class UnawareOfCancelledTasks(Unaware):
    """One whose status was ``connecting``, and is ``running`` again."""

    loss = CancelledError("scheduler-connection-lost")


@pytest.mark.parametrize("client", [Bereaved, BereavedLater, Unaware, UnawareAtStart, UnawareOfCancelledTasks])
def test_a_scheduler_that_dies_is_told_as_one(client, tmp_path):
    engine = dask_cluster.Cluster(client(), "tcp://10.0.0.1:8786")
    with pytest.raises(ConnectionError, match="the Dask scheduler was lost or restarted") as end:
        camopt.sweep(SCENE, tmp_path / "out", engine=engine)
    assert end.value.filename == "tcp://10.0.0.1:8786"
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize(
    ("seconds", "size", "items", "expected"),
    [
        (dask_cluster.TASK_SECONDS / 5.0, 0, 10_000, 10),
        (20.0 * dask_cluster.TASK_SECONDS, 0, 10_000, 1),
        (0.0, dask_cluster.TASK_BYTES / 6.9, 10_000, 13),
        (0.0, 0, 10_000, 2500),  # some tasks for each thread
        (0.0, 0, 3, 1),
    ],
)
def test_a_task_has_items_for_a_second_or_two(monkeypatch, seconds, size, items, expected):
    monkeypatch.setattr(dask_cluster, "monotonic", iter([1.0, 1.0 + seconds]).__next__)
    work = partial(bytes_of, int(size))
    one = dask_cluster.Cluster(Bereaved(), "with one thread")
    assert one._items_per_task(work, items, range(2)) == expected


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nowhere",), "scheduler = 'nowhere': must be the address of a Dask scheduler"),
        (("tcp://",), "scheduler = 'tcp://': must be the address"),
        (("tcp://10.0.0.1:8786", 4), 'workers = 4: is only for the scheduler "local"'),
    ],
)
def test_what_is_no_cluster_is_refused(arguments, message):
    with pytest.raises(BadInput, match=message), cluster(*arguments):
        pass


def test_without_dask_a_line_says_what_to_install(monkeypatch, capsys, tmp_path):
    monkeypatch.delitem(sys.modules, "camopt.core.engines.dask_cluster")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["frontier", "--scheduler", "local", "--out", str(tmp_path / "out")]) == exits.BAD_INPUT
    told = "camopt: --scheduler = 'local': needs Dask; pip install \"camopt[cluster]\" adds it\n"
    assert capsys.readouterr().err == told
    assert not [*tmp_path.iterdir()]


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_told_in_a_line(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(dask_cluster, "CONNECT_SECONDS", 0.2)
    with socket() as taken:  # nobody listens there
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        assert main(["frontier", "--scheduler", address, "--out", str(tmp_path / "out")]) == exits.FILE_TROUBLE
    assert capsys.readouterr().err == f"camopt: {address}: no Dask scheduler answers\n"
