"""The scenes that come with camopt, each with its picture, and the machines."""

import tomllib
from collections.abc import Iterator

from camopt.scene.machine import find_machine
from camopt.scene.scene import find_scene
from camopt.scene.sources import shipped_machine_toml, shipped_machines, shipped_scenes, shipped_toml
from camopt.show.drawing.notebook import cam_profile_svg


def shipped() -> Iterator[str]:
    """A card for each scene: its picture, what it is, and its text."""
    yield "::::{grid} 1 2 3 3\n:gutter: 3\n"
    for name in shipped_scenes():
        text = shipped_toml(name)
        scene = find_scene(name)
        kind = f"{scene.cam.form} cam, {scene.follower.motion} {scene.follower.contact} follower"
        yield from (f":::{{grid-item-card}} {name}", f"{tomllib.loads(text)['name']}: {kind}.", "")
        yield from ("```{raw} html", f'<div class="small-cam">{cam_profile_svg(scene)}</div>', "```", "")
        yield from ("```{dropdown} TOML", "~~~toml", text.rstrip(), "~~~", "```", ":::", "")
    yield "::::"


def shipped_with_stations() -> Iterator[str]:
    """A card for each machine: its stations, and its text."""
    yield "::::{grid} 1 2 3 3\n:gutter: 3\n"
    for name in shipped_machines():
        machine = find_machine(name)
        stations = ", ".join(station.name for station in machine.station)
        yield from (f":::{{grid-item-card}} {name}", f"{machine.name}: {stations}.", "")
        yield from ("```{dropdown} TOML", "~~~toml", shipped_machine_toml(name).rstrip(), "~~~", "```", ":::", "")
    yield "::::"
