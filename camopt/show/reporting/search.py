"""Search for the smallest cam in a separate process: the page stays usable and can stop the search."""

import os
import signal
from collections.abc import Mapping
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Lock, Thread
from typing import Any

from camopt.core.mistakes import BadInput, Mistake
from camopt.scene.scene import Scene
from camopt.solve.smallest.optimise import optimise


def find_smallest_cam_or_reason(scene: Scene) -> dict[str, Any]:
    """Find the smallest cam: its ``scene`` and the sentence ``told``, or the reason ``why`` there is none."""
    try:
        result = optimise(scene)
    except BadInput as refused:
        return {"why": "; ".join(f"{each.key}: {each.allowed}" for each in refused.mistakes)}
    if result.best is None:
        laws = "; ".join(f"{law}: {why}" for law, why in result.obstacles.items())
        return {"why": f"no cam meets all limits. Obstacles by law: {laws}"}
    best = result.best
    proof = "proved" if best["proved"] else f"a cam smaller by up to {best['gap_mm']:.3g} mm may exist"
    names = ", ".join(name.replace("_", " ") for name in best["binding"])
    active_limits = f"; active limits: {names}" if names else ""
    return {"scene": best.scene.to_dict(), "told": f"The smallest cam: {proof}{active_limits}."}


def exit_with_parent() -> None:
    """End this process when the process that started it ends."""
    parent = parent_process()
    assert parent is not None

    def wait_for_parent() -> None:
        parent.join()
        os._exit(1)

    Thread(target=wait_for_parent, daemon=True).start()


def _run_search(tables: Mapping[str, Any], file: str, result_connection: Connection) -> None:
    """Run the search in its process. It ignores Ctrl-C: the server handles that and ends the search."""
    exit_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        result_connection.send(find_smallest_cam_or_reason(Scene.from_dict(dict(tables), file)))
    except Exception as fault:
        result_connection.send({"why": f"the search failed: {type(fault).__name__}: {fault}"})


class BackgroundSearch:
    """At most one search at a time."""

    def __init__(self) -> None:
        self.lock = Lock()
        self.process: BaseProcess | None = None

    def run(self, scene: Scene) -> dict[str, Any]:
        """The answer of ``find_smallest_cam_or_reason``; the reason if the search was stopped.

        Raises
        ------
        BadInput
            If another search is running.
        """
        context = get_context("spawn")
        with self.lock:
            if self.process is not None:
                raise BadInput([Mistake("page", "smallest", None, "another search is running", bare=True)])
            receiver, sender = context.Pipe(duplex=False)
            process = context.Process(target=_run_search, args=(scene.to_dict(), scene.file, sender), daemon=True)
            process.start()
            sender.close()
            self.process = process
        try:
            answer: dict[str, Any] = receiver.recv()
            return answer
        except EOFError:
            reason = "the search ended without an answer" if self.process is process else "the search was stopped"
            return {"why": reason}
        finally:
            receiver.close()
            self.stop()

    def stop(self) -> None:
        """End the search, if there is one."""
        with self.lock:
            process, self.process = self.process, None
        if process is not None:
            process.terminate()
            process.join()
