"""``write_machine_folder``: all files of a machine in one folder, from drawings to the parts list.

Stations with the same scene share one cam: it has one drawing, and the parts list counts it.
"""

import csv
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from camopt.core.mistakes import BadInput
from camopt.core.quantities.unit_systems import MM, shown_in
from camopt.core.storage.files import write_text
from camopt.core.storage.publishing import publication
from camopt.scene.machine import Machine
from camopt.scene.scene import Scene
from camopt.scene.scene_file import write_scene
from camopt.scene.sources import path_beside_machine
from camopt.show.drawing.plot import plot
from camopt.show.exporting.export import export
from camopt.show.exporting.file_types import FILE_TYPES
from camopt.show.reporting.report import report
from camopt.solve.machine.evaluation import MachineEvaluation
from camopt.solve.tables.cells import to_json
from camopt.solve.tables.workbook import write_rows
from camopt.solve.verdicts.evaluation import evaluate

FILES = ("*.toml", "*.pdf", "*.dxf", "*.csv", "*.step", "*.xlsx", "*.html", "*.json")
"""Names of the files in the folder."""
CAM_SUFFIXES = (".pdf", ".dxf", ".csv", ".step")
"""Files of each cam: drawing, outline, points and, with the extra ``cad``, solid."""
CATALOGUE = "motors.csv"
EXTRA_MODULES = {"cad": "OCP"}


class MachineCam(NamedTuple):
    """A cam of a machine, with the stations that have it."""

    stem: str
    """Name of its files, without ending."""
    scene: Scene
    stations: tuple[str, ...]


def cams_of_machine(machine: Machine) -> list[MachineCam]:
    """The different cams of a machine, in the order of its stations, with keyways for one key of the shaft."""
    stations: dict[Scene, list[str]] = {}
    for name, scene in machine.keyed_scenes.items():
        stations.setdefault(scene, []).append(name)
    cams, stems = [], set[str]()
    for scene, names in stations.items():
        stem = plain = re.sub(r"[^\w-]+", "-", names[0].lower()).strip("-") or "cam"
        while stem in stems:
            stem = f"{plain}-{len(stems) + 1}"
        stems.add(stem)
        cams.append(MachineCam(stem, scene, tuple(names)))
    return cams


def write_machine_folder(
    result: MachineEvaluation, folder: str | os.PathLike[str]
) -> tuple[tuple[Path, ...], list[str]]:
    """Write the files of a machine: scenes, drawings, points, solids, timing diagram, page and parts list.

    Parameters
    ----------
    result : MachineEvaluation
        The evaluated machine.
    folder : str or os.PathLike
        Folder for the files; it is made if it does not exist.

    Returns
    -------
    tuple
        The files, and notes on cams that have no drawing, since they cannot be made.

    Raises
    ------
    BadInput
        If a file in the folder is not one of camopt.
    OSError
        If a file cannot be written.
    """
    machine, notes = result.machine, list[str]()
    cams = cams_of_machine(machine)
    with publication(folder, "machine", FILES) as output:
        for cam in cams:
            write_scene(output.staged_path(f"{cam.stem}.toml"), cam.scene)
            notes += _write_cam_files(cam, output.staging)
        # scenes and catalogue are beside the file of the machine
        files = {name: f"{cam.stem}.toml" for cam in cams for name in cam.stations}
        stations = [station.model_copy(update={"scene": files[station.name]}) for station in machine.station]
        motor = machine.motor and machine.motor.model_copy(update={"catalogue": CATALOGUE})
        moved = machine.model_copy(update={"station": tuple(stations), "motor": motor})
        write_text(output.staged_path("machine.toml"), moved.to_toml())
        if machine.motor:
            catalogue = path_beside_machine(machine.folder, machine.motor.catalogue)
            shutil.copyfile(catalogue, output.staged_path(CATALOGUE))
        rows = [*parts_list_rows(machine, cams)]
        headings = [*dict.fromkeys(name for row in rows for name in row)]
        texts = [headings, *([row.get(name, "") for name in headings] for row in rows)]
        with output.staged_path("parts.csv").open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(texts)
        if find_spec("xlsxwriter"):
            write_rows(output.staged_path("parts.xlsx"), "parts", texts)
        write_text(output.staged_path("machine.json"), to_json(result.to_dict()))
        plot(result, output.staged_path("timing.pdf"))
        report(result, output.staged_path("machine.html"))
    return output.files, notes


def _write_cam_files(cam: MachineCam, staging: Path) -> Iterator[str]:
    """Write the files of a cam; yields a note for each kind that the cam cannot have."""
    for suffix in CAM_SUFFIXES:
        extra = FILE_TYPES[suffix].extra
        if extra and not find_spec(EXTRA_MODULES[extra]):
            continue
        try:
            export(cam.scene, staging / f"{cam.stem}{suffix}")
        except BadInput as refused:
            yield f"no {cam.stem}{suffix}: {refused.mistakes[0].key}: {refused.mistakes[0].allowed}"


def parts_list_rows(machine: Machine, cams: Sequence[MachineCam]) -> Iterator[dict[str, Any]]:
    """The rows of the parts list: each cam, its rollers and its springs, with their number."""
    numbers, phases = count(1), {station.name: station.phase for station in machine.station}
    for cam in cams:
        scene, part, quantity = cam.scene, cam.scene.whole_part, len(cam.stations)
        mechanism, dynamics = scene.mechanism, scene.follower.dynamics
        discs = 2 if mechanism.second_contact_size_keys else 1
        common = {"quantity": quantity, "stations": ", ".join(cam.stations)}
        yield {
            "item": next(numbers),
            "part": part.name,
            **common,
            "quantity": quantity * discs,
            "phase deg": ", ".join(f"{phases[name]:g}" for name in cam.stations),
            "number": part.number or "",
            "material": part.material or "",
            "hardness": part.hardness or "",
            "base or mean radius mm": getattr(scene.cam, mechanism.body.size_key),
            "thickness mm": part.thickness or "",
            "bore mm": part.bore or "",
            "keyway deg": "" if part.keyway_angle is None else part.keyway_angle,
            "mass kg": _cam_mass_kg_or_empty(scene),
            "drawing": f"{cam.stem}.pdf",
        }
        if scene.tip.radius and scene.follower.roller_radius and scene.tip.name == "roller":
            rollers = {**common, "quantity": quantity * (1 + len(mechanism.further_contacts))}
            size = {"diameter mm": 2.0 * scene.follower.roller_radius}
            yield {"item": next(numbers), "part": "Roller", **rollers, **size}
        if dynamics and dynamics.spring_rate:
            unit = "N·m/rad, N·m" if mechanism.motion.angular and not scene.straight_spring else "N/mm, N"
            spring = {"rate": dynamics.spring_rate, "preload": dynamics.preload or 0.0, "rate and preload in": unit}
            yield {"item": next(numbers), "part": "Spring", **common, **spring}


def _cam_mass_kg_or_empty(scene: Scene) -> float | str:
    """Mass of the cam [kg]; empty if the scene does not give thickness and density."""
    with shown_in(MM):
        try:
            return round(evaluate(scene.replace(outputs=["cam_mass_kg"]))["cam_mass_kg"], 4)
        except BadInput:
            return ""
