"""Controllers of machines as far as camopt's programs need them: an interpreter for each dialect.

Each reads the text alone, and keeps the state of a machine: position, feed, tool, spindle, coolant. A word that it
does not know, a centre that is not in the middle, a move before the modes are set, or a spindle that stands in the
steel is an error.
"""

import re
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Cut:
    """A way at one depth: where it began, dense points of each move at a feed, and the feeds."""

    depth: float | None
    moves: list = field(default_factory=list)
    feeds: list = field(default_factory=list)

    @property
    def points(self):
        return np.concatenate(self.moves)


class Machine:
    """What all controls have in common."""

    def __init__(self, decimals):
        self.at, self.z, self.feed, self.tool, self.speed = None, None, None, None, None
        self.turning = self.coolant = self.ended = False
        self.turned = self.cooled = False
        self.decimals, self.cuts, self.comments, self.arcs = decimals, [], [], 0

    def number(self, text):
        assert len(text.partition(".")[2]) <= self.decimals, text
        return float(text)

    def rapid(self, to):
        assert self.z is None or self.z > 0.0, "rapid in the steel"
        self.at = to
        self.cuts.append(Cut(None))

    def level(self, z, rapid):
        assert not rapid or self.z is None or z > 0.0, "rapid into the steel"
        self.z = z
        if not rapid:
            self.cuts[-1].depth = z

    def move(self, points):
        assert points[-1] != self.at, "a move of no length"
        self.turned |= self.turning
        self.cooled |= self.coolant
        assert self.feed, "no feed"
        assert self.tool is None or self.turning, "the spindle stands"
        self.cuts[-1].moves.append(points)
        self.cuts[-1].feeds.append(self.feed)
        self.at = points[-1]

    def stop(self, code):
        assert self.z is None or self.z > 0.0, "stops in the steel"
        assert self.turning if code == "M5" else self.coolant, f"{code} of what is off"
        self.turning, self.coolant = self.turning and code != "M5", self.coolant and code != "M9"

    def end(self):
        assert not self.turning, "ends with the spindle on"
        assert not self.coolant, "ends with the coolant on"
        self.ended = True

    def line(self, to):
        self.move(self.at + (to - self.at) * np.linspace(0.0, 1.0, 400))

    def arc(self, to, centre, anticlockwise):
        turn = np.angle((to - centre) / (self.at - centre))
        turn = turn % (2 * np.pi) if anticlockwise else -(-turn % (2 * np.pi))
        radii = abs(self.at - centre), abs(to - centre)
        assert abs(radii[1] - radii[0]) < 3 * 10.0**-self.decimals, "the centre is not in the middle"
        self.arcs += 1
        self.move(centre + (self.at - centre) * np.exp(1j * turn * np.linspace(0.0, 1.0, 600)))


def run_iso(program, decimals=4, comment=r"\((.*)\)", modes=("G21", "G17", "G90", "G94", "G40"), ends=("M30",)):
    """A control of ISO 6983; Fanuc's and Siemens's differ in comments, modes and the first and last lines."""
    machine, set_modes = Machine(decimals), set()
    for line in program.splitlines():
        if said := re.fullmatch(comment, line):
            machine.comments.append(said[1])
            continue
        if line in ("%", "O0001"):
            assert ends == ("M30", "%"), "a Fanuc line"
            continue
        assert not machine.ended, line
        assert re.fullmatch(r"([A-Z]-?[\d.]+ ?)+", line), line
        words = re.findall(r"([A-Z])(-?[\d.]+)", line)
        codes = [f"{letter}{value}" for letter, value in words if letter in "GM"]
        values = {letter: machine.number(text) for letter, text in words if letter not in "GMTDSHF"}
        other = {letter: float(text) for letter, text in words if letter in "TDSHF"}
        machine.feed = other.get("F", machine.feed)
        machine.speed = other.get("S", machine.speed)
        machine.tool = int(other["T"]) if "T" in other else machine.tool
        assert other.get("H", machine.tool) == machine.tool
        for code in codes:
            if code in ("G0", "G1", "G2", "G3"):
                assert set(modes) <= set_modes, "modes are not set"
                _iso_move(machine, code, values)
            elif code in (*modes, "G49", "G80", "G54", "G43"):
                set_modes.add(code)
            elif code == "M6":
                assert machine.tool, "no tool"
            elif code == "M3":
                assert machine.speed, "no speed"
                machine.turning = True
            elif code == "M8":
                machine.coolant = True
            elif code in ("M5", "M9"):
                machine.stop(code)
            else:
                assert code == "M30", code
                machine.end()
    assert machine.ended
    assert program.splitlines()[-len(ends) :] == list(ends)
    return machine


def _iso_move(machine, code, values):
    if "Z" in values:
        assert set(values) == {"Z"}
        return machine.level(values["Z"], code == "G0")
    to = complex(values["X"], values["Y"])
    if code == "G0":
        return machine.rapid(to)
    if code == "G1":
        return machine.line(to)
    return machine.arc(to, machine.at + complex(values["I"], values["J"]), code == "G3")


def run_fanuc(program, decimals=3):
    assert program.startswith("%\nO0001\n")
    return run_iso(program, decimals, ends=("M30", "%"))


def run_siemens(program, decimals=4):
    return run_iso(program, decimals, r"; (.*)", ("G71", "G17", "G90", "G94", "G40"))


XY = r"X([+-][\d.]+) Y([+-][\d.]+)"
FED = r"(?: F(\d+(?:\.\d+)?))?"


def run_heidenhain(program, decimals=4):  # noqa: C901
    """A conversational control: numbered blocks, centres as blocks of their own, a sign before each coordinate."""
    machine, centre = Machine(decimals), None
    blocks = [line.partition(" ") for line in program.splitlines()]
    assert [int(number) for number, _, _ in blocks] == list(range(len(blocks)))
    first, *texts, last = (text for _, _, text in blocks)
    assert (first, last) == ("BEGIN PGM CAM MM", "END PGM CAM MM")

    def point(found):
        return complex(machine.number(found[1]), machine.number(found[2]))

    for text in texts:
        assert not machine.ended, text
        if found := re.fullmatch(r"; (.*)", text):
            machine.comments.append(found[1])
        elif found := re.fullmatch(r"TOOL CALL (\d+) Z S(\d+(?:\.\d+)?)", text):
            machine.tool, machine.speed = int(found[1]), float(found[2])
        elif found := re.fullmatch(rf"L {XY} R0 FMAX", text):
            machine.rapid(point(found))
        elif found := re.fullmatch(r"L Z([+-][\d.]+) R0 FMAX", text):
            machine.level(machine.number(found[1]), True)
        elif found := re.fullmatch(rf"L Z([+-][\d.]+) R0{FED}", text):
            machine.feed = float(found[2]) if found[2] else machine.feed
            machine.level(machine.number(found[1]), False)
        elif found := re.fullmatch(rf"L {XY} R0{FED}", text):
            machine.feed = float(found[3]) if found[3] else machine.feed
            machine.line(point(found))
        elif found := re.fullmatch(f"CC {XY}", text):
            centre = point(found)
        elif found := re.fullmatch(rf"C {XY} DR([+-]){FED}", text):
            machine.feed = float(found[4]) if found[4] else machine.feed
            machine.arc(point(found), centre, found[3] == "+")
        elif text == "M3":
            assert machine.speed, "no speed"
            machine.turning = True
        elif text == "M8":
            machine.coolant = True
        elif text in ("M5", "M9"):
            machine.stop(text)
        else:
            assert text == "M30", text
            machine.end()
    assert machine.ended
    return machine


CONTROLS = {"iso": run_iso, "fanuc": run_fanuc, "siemens": run_siemens, "heidenhain": run_heidenhain}


@dataclass
class Turning:
    """A machine with an axis that turns the part: where the cutter was, and the minutes that it took.

    ``states`` has along, lateral, radial (mm) and rotary (deg) at the ends of moves in the steel.
    """

    states: list = field(default_factory=list)
    minutes: float = 0.0
    feeds: list = field(default_factory=list)


TURNING_MODES = {
    "iso": ("G21 G17 G90 G94 G40", "G93", "G94", "M30"),
    "fanuc": ("G21 G17 G90 G94 G40 G49 G80 G54", "G93", "G94", "M30"),
    "siemens": ("G71 G17 G90 G94 G40 G54", "G93", "G94", "M30"),
    "heidenhain": ("", "M116", "M117", "M30"),
}


PLANES = {"Z": "G17", "X": "G19"}
"""Of arcs, to which the tool is square: its length counts along an axis."""


def run_turning(program, control, along="X", radial="Z", rotary="A", clear=0.0):
    """A control of four axes that runs the program of a groove: fast moves keep above ``clear``, mm."""
    lines = [line.partition(" ")[2] if control == "heidenhain" else line for line in program.splitlines()]
    modes, by_time, back, end = (each.replace("G17", PLANES[radial]) for each in TURNING_MODES[control])
    assert control != "heidenhain" or any(re.match(rf"TOOL CALL \d+ {radial} S", line) for line in lines)
    at = dict.fromkeys((along, "Y", radial, rotary))
    machine, set_up, rate = Turning(), not modes, None
    for line in lines:
        assert line != back or by_time in lines[: lines.index(back)]
        if line in (modes, by_time, back, end) or not (found := re.match(r"(G0|G1|L) (?=[XYZAC])", line)):
            set_up |= line == modes
            continue
        assert set_up, "modes are not set"
        to = {
            letter: float(number) for letter, number in re.findall(r"([XYZACF])([+-]?[\d.]+)", line[found.end() :])
        }
        rate = to.pop("F", rate if control == "heidenhain" else None)
        fast = found[1] == "G0" or "FMAX" in line
        assert to.keys() <= at.keys(), line
        assert fast or rate, "no feed"
        assert not fast or max(at[radial] or clear, to.get(radial, clear)) >= clear, "fast in the steel"
        assert fast or radial not in to or len(to) == 1
        at |= to
        if not fast:
            machine.states.append([at[along], at["Y"] or 0.0, at[radial], at[rotary]])
            machine.feeds.append(rate)
            machine.minutes += 1.0 / rate
    assert lines.index(back) < lines.index(end)
    return machine
