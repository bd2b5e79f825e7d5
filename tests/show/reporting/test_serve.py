"""The served page: answers against the library, what is refused, what is written, and a real browser."""

import http.client
import json
import os
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from functools import cache
from http.server import BaseHTTPRequestHandler, HTTPServer
from multiprocessing import Pipe
from threading import Thread
from urllib.parse import urlsplit

import numpy as np
import pymupdf
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.browser import running_browser, watched_page

import camopt
from camopt.core.kernels import compile
from camopt.scene.problem.problem import resolve_design
from camopt.show.reporting import search
from camopt.show.reporting.controls import controls_of, scene_with_settings
from camopt.show.reporting.sections import number_text_with_minus_sign
from camopt.show.reporting.server import MOST_BYTES, MOST_UNKNOWN_CONNECTIONS, open_server
from camopt.show.reporting.session import MachineSession, Session, answer_request
from camopt.solve.tolerances.batch import yield_of_cams

MOVES = {
    "two-pauses": {"cam.base_radius": 41.0},
    "knife-900rpm-offset": {"follower.offset": -7.5, "cam.rpm": 500.0},
    "flat-reciprocating": {"cam.base_radius": 33.0, "law_rise": "cycloidal"},
    "oscillating-roller": {"follower.roller_radius": 7.0},
    "eccentric-rocker": {"follower.arm_length": 52.0},
    "feeder-with-stop": {"cam.mean_radius": 130.0, "limits.pressure_angle": 25.0},
    "valve-rod-offset": {"law_return": "poly345", "motion.1.angle": 70.0},
    "tangent-cam": {"follower.dynamics.spring_rate": 40.0},
    "bottle-filler-by-rib": {"cam.rpm": 61.0},
}


@cache
def session_of(name="two-pauses", folder=None):
    return Session(camopt.find_scene(name), folder)


def request_values(values, **more):
    return {"values": values, **more}


def texts(answer):
    """All cells of the tables of an answer."""
    tables = [answer["limits"], *(table for section in answer["sections"] for table in section["tables"])]
    return {cell.text for table in tables for row in table["rows"] for cell in row}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", MOVES)
def test_each_answer_is_that_of_the_library(name):
    session, values = session_of(name), MOVES[name]
    moved = next((key for key in values if key.startswith("motion.")), "")
    scene = scene_with_settings(session.scene, session.initial_values, values, moved)
    cam = camopt.evaluate(scene)
    quick, proved = (
        answer_request(session, what, request_values(values, moved=moved)) for what in ("move", "settle")
    )
    for answer in (quick, proved):
        assert answer["values"].items() >= values.items()
        assert answer["cam"]["steepest"] == pytest.approx(cam["pressure_angle_max_deg"], rel=1e-7)
        sampled = max(max(piece["y"]) for piece in answer["cam"]["motion"]["pieces"])
        assert answer["cam"]["motion"]["lift"] == pytest.approx(sampled, rel=1e-4)
        json.dumps(answer, allow_nan=False)
    verdicts = camopt.certify(scene)
    held = set(verdicts.values()) == {"held"}
    assert [line[0].startswith("Feasible") for line in (quick["lines"][0], proved["lines"][0])] == [held, held]
    assert texts(proved) >= {
        number_text_with_minus_sign(value) for key, value in cam.items() if value and key.endswith(("_mm", "_deg"))
    }
    found = {row[0].text.replace(" ", "_"): row[1].text for row in quick["limits"]["rows"]}
    assert {
        limit: verdict for limit, verdict in found.items() if verdict != "undecided"
    }.items() <= verdicts.items()
    assert len(quick["cam"]["panels"]) == len(proved["cam"]["panels"])


def test_of_a_cam_that_cannot_be_put_together_nothing_else_is_said():
    face = {"motion": "oscillating", "contact": "flat", "centre_distance": 80.0, "face_offset": 5.0}
    scene = camopt.find_scene("oscillating-roller").replace(follower=face, limits={"face_reach": 90.0})
    asked = request_values({"motion.3.angle": 336.0}, moved="motion.3.angle")
    for what in ("move", "settle"):
        answer = answer_request(Session(scene, None), what, asked)
        assert answer["cam"] == {"exists": False}
        assert answer["lines"][0].text == "Not feasible: assembly."
        assert [(row[0].text, row[1].text) for row in answer["limits"]["rows"]] == [("assembly", "broken")]


def test_the_slider_of_a_number_goes_as_far_as_search_says_or_the_scene_allows():
    scene = camopt.find_scene("roller-1000rpm")
    found = {control.key: control for control in controls_of(scene)}
    base, offset, roller = (found[key] for key in ("cam.base_radius", "follower.offset", "follower.roller_radius"))
    assert (base.low, base.high, base.step, base.unit) == (20.0, 150.0, 0.5, "mm")
    assert (offset.low, offset.high) == (-30.0, 30.0)
    assert roller.options == tuple(map(float, (5, 6, 8, 10, 12, 14, 16, 18, 20)))
    for control in found.values():
        for value in (control.low, control.high) if control.step and control.group != "Angles of the turn" else ():
            scene.replace(**{control.key: value})


@pytest.mark.slow
def test_tolerances_have_sliders_and_a_line_follows_them(tmp_path):
    """Those that are one number; what else a scene says of them stays."""
    uniform = {"plus": 0.05, "minus": 0.05, "distribution": "uniform"}
    scene = camopt.find_scene("rocker-valve").replace(
        tolerances={"follower.arm_length": uniform, "follower.roller_radius": "h6", "profile": 0.02, "phase": 0.05}
    )
    session = Session(scene, tmp_path)
    found = {each.key: each for each in session.controls if each.group == "Tolerances"}
    assert [*found] == [f"tolerances.{key}" for key in ("follower.arm_length", "phase", "profile")]
    assert [each.unit for each in found.values()] == ["mm", "deg", "mm"]
    values = {each.key: each.value for each in session.controls} | {"tolerances.follower.arm_length": 0.1}
    moved = session.scene_of_request({"values": values})
    wider = {**uniform, "plus": 0.1, "minus": 0.1}
    assert moved == scene.replace(**{"tolerances.follower.arm_length": wider})
    lines = [
        line.text
        for line in session.quick_cam_answer({"values": values, "moved": "tolerances.follower.arm_length"})["lines"]
    ]
    worst = camopt.tolerance(moved).errors[0].worst
    assert any(
        f"Largest error within the tolerances: displacement {worst:.6g} deg" in line and "velocity ∞" in line
        for line in lines
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "given", "limits"),
    [
        (
            "rocker-valve",
            {"follower.arm_length": 0.05, "profile": 0.02, "bore_eccentricity": 0.03},
            {"position_error": 0.07, "dwell_error": 0.05, "pressure_angle": 24.52},
        ),
        ("press-feed-by-pair", {"follower.arm_length": 0.05, "profile": 0.01}, {"pressure_angle": 26.42}),
    ],
)
def test_the_yield_follows_a_slider_and_is_that_of_a_batch(tmp_path, name, given, limits):
    scene = camopt.find_scene(name).replace(part={}, tolerances=given, limits=limits)
    session, problem = Session(scene, tmp_path), resolve_design(scene)
    values = {each.key: each.value for each in session.controls}
    lines = [line.text for line in session.quick_cam_answer({"values": values})["lines"]]
    batch = camopt.sample_cams(scene, cams=256)
    assert batch.held.share < 1.0
    told = next(line for line in lines if line.startswith("Yield: "))
    assert f"{100.0 * batch.held.share:.4g} % of 256 random cams meet the limits" in told
    assert f"({100.0 * batch.held.low:.4g} to" in told
    assert yield_of_cams(scene, problem, 256) == batch.held
    with_no_limit = scene.replace(limits={}, tolerances={"profile": 0.01})
    assert yield_of_cams(with_no_limit, resolve_design(with_no_limit), 256) is None


def test_sliders_are_in_the_units_that_are_shown(tmp_path):
    """In inch; what was not moved keeps its digits, and what the page says is the cam that the scene is in mm."""
    scene, name = camopt.find_scene("roller-1000rpm"), "cam.base_radius"
    with camopt.shown_in("inch"):
        session = Session(scene, tmp_path)
        base, law = ({c.key: c for c in session.controls}[key] for key in (name, "law_rise"))
        assert (base.value * 25.4, base.low * 25.4, base.shown_unit) == (
            pytest.approx(50.0),
            pytest.approx(20.0),
            "in",
        )
        assert law.shown_unit == ""
        assert ">base radius<small>, in</small>" in session.page()
        start = answer_request(session, "settle", request_values({}))["values"]
        assert session.scene_of_request(request_values(start)) == scene
        moved = answer_request(session, "settle", request_values({**start, name: 2.5}))
    assert moved["values"][name] == 2.5
    cam = camopt.evaluate(scene.replace(**{name: 63.5}))
    assert moved["cam"]["steepest"] == pytest.approx(cam["pressure_angle_max_deg"], rel=1e-7)


@pytest.mark.slow
@given(st.sampled_from(["two-pauses", "rocker-valve"]), st.integers(1, 4), st.floats(0.0, 360.0))
@settings(max_examples=20)
def test_other_segments_make_room_for_the_one_that_is_moved(name, place, angle):
    scene, own = session_of(name).scene, session_of(name).initial_values
    key, before = f"motion.{place}.angle", np.array([segment.angle for segment in scene.motion])
    expected = before * (360.0 - angle) / (360.0 - before[place - 1])
    expected[place - 1] = angle
    moving = np.array([segment.segment != "dwell" for segment in scene.motion])
    changed, refused = None, set()
    try:
        changed = scene_with_settings(scene, own, {**own, key: angle}, key)
    except camopt.BadInput as error:
        refused = {mistake.key for mistake in error.mistakes}
    short = {f"motion.{k + 1}.angle" for k in np.flatnonzero(moving & (expected < 1e-6))}
    assert refused == short or (name, refused) == ("rocker-valve", {"motion.lift"})  # its arm would turn too far
    assume(changed)
    assert [segment.angle for segment in changed.motion] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("values", "key", "text"),
    [
        ({"cam.base_radius": -1.0}, "cam.base_radius", "must be at least 1e-09"),
        ({"cam.base_radius": float("inf")}, "cam.base_radius", "must be a finite number"),
        ({"cam.base_radius": "wide"}, "cam.base_radius", "must be a number"),
        ({"law_rise": "sudden"}, "motion.1.law", "known: uniform"),
        ({"follower.offset": 900.0}, "follower.offset", "smaller than the prime radius"),
        ({"cam.basis": 1.0}, "cam.basis", "not a control; did you mean cam.base_radius?"),
        ({"name": "other"}, "name", "not a control"),
        ({"motion.1.angle": 999.0}, "motion", ""),
        ({"motion.1.angle": "x"}, "motion", ""),
    ],
)
def test_a_bad_value_is_told_with_its_key_and_nothing_else(values, key, text):
    answer = answer_request(session_of(), "move", request_values(values, moved=next(iter(values))))
    (mistake, *_) = answer["mistakes"]
    assert [*answer] == ["mistakes"]
    assert mistake["key"].startswith(key)
    assert text in mistake["text"]


JSONS = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=6,
)
KEYS = [*session_of().initial_values]


@given(
    JSONS
    | st.fixed_dictionaries(
        {
            "values": st.dictionaries(
                st.sampled_from(KEYS) | st.text(max_size=6), st.floats() | st.text(max_size=5), max_size=3
            )
        },
        optional={"moved": st.sampled_from(KEYS) | st.text(max_size=4), "name": JSONS, "more": JSONS},
    )
)
@settings(max_examples=60)
def test_whatever_is_asked_is_answered_or_refused_in_words(asked):
    answer = answer_request(session_of(), "move", asked)
    json.dumps(answer, allow_nan=False)
    assert ("mistakes" in answer) != ("cam" in answer)


def test_what_is_saved_is_the_scene_that_is_shown(tmp_path):
    session = session_of(folder=tmp_path)
    asked = request_values({"cam.base_radius": 47.0, "law_rise": "cycloidal"}, name="my cam-1.toml")
    assert answer_request(session, "save", asked) == {"saved": str(tmp_path / "my cam-1.toml")}
    assert camopt.Scene.from_toml(tmp_path / "my cam-1.toml") == session.scene_of_request(asked)
    before = (tmp_path / "my cam-1.toml").read_bytes()
    other = {**asked, "values": {"cam.base_radius": 48.0}}
    assert answer_request(session, "save", other) == {"exists": "my cam-1.toml"}
    assert (tmp_path / "my cam-1.toml").read_bytes() == before
    assert "saved" in answer_request(session, "save", {**other, "overwrite": True})
    assert camopt.find_scene(tmp_path / "my cam-1.toml").cam.base_radius == 48.0


@pytest.mark.parametrize(
    "name",
    [
        *("../up.toml", "/etc/cam.toml", "a/b.toml", "a\\b.toml", "c:cam.toml", "cam.toml\n", "cam\0.toml"),
        *("..toml", ".toml", ".hidden.toml", "cam.txt", "cam", "", "x" * 200 + ".toml", None),
        *("folder.toml", "link.toml"),
    ],
)
def test_nothing_is_written_but_a_plain_file_in_the_folder(name, tmp_path):
    folder, target = tmp_path / "folder", tmp_path / "target.toml"
    (folder / "folder.toml").mkdir(parents=True)
    target.write_text("mine", encoding="utf-8")
    (folder / "link.toml").symlink_to(target)
    before = sorted(tmp_path.rglob("*"))
    answer = answer_request(session_of(folder=folder), "save", request_values({}, name=name, overwrite=True))
    assert "mistakes" in answer
    assert sorted(tmp_path.rglob("*")) == before
    assert target.read_text(encoding="utf-8") == "mine"


def test_the_page_of_a_report_is_that_of_the_scene_shown(tmp_path):
    session, asked = session_of("flat-reciprocating"), request_values({"cam.base_radius": 47.0})
    expected = camopt.report(session.scene_of_request(asked), tmp_path / "cam.html").read_text(encoding="utf-8")
    answer = answer_request(session, "report", asked)
    assert answer == {"name": "Flat-faced-reciprocating-follower.html", "text": expected}


def test_the_smallest_cam_is_that_of_optimise():
    scene = camopt.find_scene("knife-300rpm-offset")
    found, best = search.find_smallest_cam_or_reason(scene), camopt.optimise(scene).best
    assert found["scene"] == best.scene.to_dict()
    assert "proved" in found["told"]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"limits": {}}, "nothing limits the size"),
        ({"limits": {"pressure_angle": 0.01}, "search": {"base_radius": [40.0]}}, "pressure_angle"),
    ],
)
def test_why_there_is_no_smallest_cam(changes, why):
    assert (
        why
        in search.find_smallest_cam_or_reason(camopt.find_scene("knife-300rpm-radial").replace(**changes))["why"]
    )


@pytest.fixture
def _plainly(monkeypatch):
    """Serving sets when kernels are compiled for the whole process."""
    monkeypatch.setattr(compile, "COMPILATION", compile.COMPILATION)


@contextmanager
def served(name, folder):
    told = []
    what = camopt.find_machine(name) if name in camopt.shipped_machines() else camopt.find_scene(name)
    with open_server(what, folder, notify=told.append) as server:
        thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()
    assert told == []


@pytest.mark.usefixtures("_plainly")
def test_a_scene_whose_size_is_to_be_found_opens_with_its_smallest_cam(tmp_path):
    changes = {"cam.base_radius": None, "search": {"law": ["cycloidal"]}}
    scene, told = camopt.find_scene("roller-1000rpm").replace(**changes), []
    with open_server(scene, tmp_path, notify=told.append) as server:
        best = camopt.optimise(scene).best
        assert server.session.initial_values["cam.base_radius"] == best["base_radius_mm"]
    assert told == ["The scene lacks sizes; the page opens with its smallest cam."]


@pytest.fixture
def server(tmp_path, _plainly):
    with served("two-pauses", tmp_path) as found:
        yield found


def request(server, method, path, body=None, headers=None):
    """Status, headers and text of one request, with the headers of the page unless others are given."""
    host = f"127.0.0.1:{server.server_port}"
    usual = {"Host": host, "Origin": f"http://{host}", "Content-Type": "application/json"}
    sent = {key: value for key, value in {**usual, **(headers or {})}.items() if value is not None}
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
    try:
        connection.request(method, path, body, sent)
        answer = connection.getresponse()
        return answer.status, dict(answer.headers), answer.read().decode()
    finally:
        connection.close()


QUESTION = json.dumps({"values": {"cam.base_radius": 45}})


def test_the_page_and_its_questions(server):
    status, headers, text = request(server, "GET", f"/{server.token}/")
    assert status == 200
    assert "connect-src 'self'" in text
    assert "default-src 'none'" in text
    assert headers["Cache-Control"] == "no-store"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "Access-Control-Allow-Origin" not in headers
    status, _, text = request(server, "POST", f"/{server.token}/move", QUESTION)
    assert status == 200
    assert json.loads(text)["cam"]["sizes"]["size"] == 45.0


def test_a_ticket_leads_to_the_page_once(server):
    path = urlsplit(server.one_time_address).path
    status, headers, text = request(server, "GET", path)
    assert (status, headers["Location"], text) == (303, f"/{server.token}/", "")
    assert request(server, "GET", path)[0] == 403
    assert request(server, "GET", "/")[0] == 403


@pytest.mark.parametrize(
    ("method", "path", "headers", "status"),
    [
        ("GET", "/", {}, 403),
        ("GET", "/wrong/", {}, 403),
        ("GET", "/%00/", {}, 403),
        ("GET", "/TOKEN%2f", {}, 403),
        ("GET", "/TOKEN", {}, 404),
        ("GET", "/TOKEN/../../etc/passwd", {}, 404),
        ("GET", "/TOKEN/move", {}, 404),
        ("GET", "/TOKEN/", {"Host": "evil.example"}, 403),
        ("GET", "/TOKEN/", {"Host": "127.0.0.1"}, 403),
        ("GET", "/TOKEN/", {"Host": "127.0.0.1:1"}, 403),
        ("POST", "/wrong/move", {}, 403),
        ("POST", "/TOKEN/", {}, 404),
        ("POST", "/TOKEN/nothing", {}, 404),
        ("POST", "/TOKEN/../move", {}, 404),
        ("POST", "/TOKEN/move", {"Host": "rebound.example:80"}, 403),
        ("POST", "/TOKEN/move", {"Origin": "http://evil.example"}, 403),
        ("POST", "/TOKEN/move", {"Origin": "null"}, 403),
        ("POST", "/TOKEN/move", {"Origin": None}, 403),
        ("POST", "/TOKEN/move", {"Content-Type": "text/plain"}, 415),
        ("POST", "/TOKEN/move", {"Content-Length": "-1"}, 400),
        ("POST", "/TOKEN/move", {"Content-Length": "1e3"}, 400),
        ("POST", "/TOKEN/move", {"Content-Length": str(MOST_BYTES + 1)}, 413),
        ("POST", "/TOKEN/move", {"Content-Length": "9" * 5000}, 413),
        ("POST", "/TOKEN/move", {"Transfer-Encoding": "chunked"}, 400),
        ("OPTIONS", "/TOKEN/move", {"Origin": "http://evil.example"}, 501),
        ("HEAD", "/TOKEN/", {}, 501),
        ("PUT", "/TOKEN/save", {}, 501),
    ],
)
def test_what_is_refused_is_told_nothing(server, method, path, headers, status):
    found, told, text = request(server, method, path.replace("TOKEN", server.token), QUESTION, headers)
    assert (found, text) == (status, "")
    assert {*told} <= {
        *("Server", "Date", "Cache-Control", "Content-Security-Policy", "Cross-Origin-Opener-Policy", "Connection"),
        *("Cross-Origin-Resource-Policy", "Referrer-Policy", "X-Content-Type-Options", "Content-Type"),
        "Content-Length",
    }
    assert told["Server"] == "camopt"


@pytest.mark.parametrize(
    "body",
    ["", "{", "[1,2", '{"values": {"cam.base_radius": NaN}}', '{"values": {"cam.base_radius": -Infinity}}',
     "[" * 50_000, b"\xff\xfe\x00"],
)  # fmt: skip
def test_what_is_no_json_is_refused(server, body):
    assert request(server, "POST", f"/{server.token}/move", body)[::2] == (400, "")


@pytest.mark.parametrize("number", ["1e999", "1" * 400, "1" * 5000])
def test_numbers_beyond_all_bounds_are_mistakes(server, number):
    body = f'{{"values": {{"cam.base_radius": {number}}}}}'
    status, _, text = request(server, "POST", f"/{server.token}/move", body)
    assert status == 200
    assert json.loads(text)["mistakes"][0]["key"] == "cam.base_radius"


def test_a_connection_that_breaks_off_leaves_the_server(server):
    for start in (
        b"",
        b"POST /",
        b"GET / HTTP/1.1\r\n\r\n",
        b"\x16\x03\x01\x00",
        b"GET /\xc3\xa9/ HTTP/1.1\r\nHost: \xff\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
    ):
        with socket.create_connection(("127.0.0.1", server.server_port)) as one:
            one.sendall(start)
    assert request(server, "POST", f"/{server.token}/move", QUESTION)[0] == 200


@pytest.mark.parametrize(("error", "is_printed"), [(BrokenPipeError(), False), (ZeroDivisionError(), True)])
def test_only_a_broken_connection_is_ignored(server, capsys, error, is_printed):
    try:
        raise error
    except type(error):
        server.handle_error(None, ("127.0.0.1", 1))
    assert (type(error).__name__ in capsys.readouterr().err) == is_printed


def test_the_server_listens_on_this_machine_alone(server):
    assert server.socket.getsockname()[0] == "127.0.0.1"


def test_strangers_make_room_for_each_other_and_leave_the_page_alone(server):
    """Connections that never say who they are: the oldest go, and who has the token is answered and stays."""
    page = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    strangers = []
    try:
        for _ in range(3):
            page.request("GET", f"/{server.token}/")
            assert page.getresponse().read()
            connection = page.sock
            strangers += [
                socket.create_connection(("127.0.0.1", server.server_port)) for _ in range(MOST_UNKNOWN_CONNECTIONS)
            ]
            assert page.sock is connection
        assert request(server, "POST", f"/{server.token}/move", QUESTION)[0] == 200
        for gone in strangers[:-MOST_UNKNOWN_CONNECTIONS]:
            gone.settimeout(20)
            assert gone.recv(1) == b""
        assert len(server.unknown_connections) <= MOST_UNKNOWN_CONNECTIONS
        head = f"GET /{server.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\n\r\n"
        strangers[-1].sendall(head.encode())
        assert strangers[-1].recv(12) == b"HTTP/1.1 200"
    finally:
        for each in (page, *strangers):
            each.close()


ORPHAN = """
import sys, time
from multiprocessing import get_context
from camopt.show.reporting.search import exit_with_parent

def search():
    exit_with_parent()
    print("searching", flush=True)
    time.sleep(600)

if __name__ == "__main__":
    process = get_context("spawn").Process(target=search, daemon=True)
    process.start()
    process.join()
"""


def test_a_search_ends_with_a_server_that_is_killed(tmp_path):
    (tmp_path / "orphan.py").write_text(ORPHAN, encoding="utf-8")
    running = subprocess.Popen([sys.executable, tmp_path / "orphan.py"], stdout=subprocess.PIPE, text=True)
    assert running.stdout.readline() == "searching\n"
    running.kill()
    assert running.communicate(timeout=60)[0] == ""  # the search has the pipe, too, as long as it is there


def test_the_process_of_a_search_watches_its_server(monkeypatch):
    seen = []
    monkeypatch.setattr(search, "exit_with_parent", lambda: seen.append("watched"))
    monkeypatch.setattr(search, "find_smallest_cam_or_reason", lambda scene: seen.append("searched"))
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    ours, theirs = Pipe()
    search._run_search(camopt.find_scene("two-pauses").to_dict(), "two-pauses", theirs)
    assert seen == ["watched", "searched"]
    assert ours.recv() is None


def test_a_search_is_called_off():
    slow = search.BackgroundSearch()
    answers = []
    thread = Thread(target=lambda: answers.append(slow.run(camopt.find_scene("roller-1000rpm"))))
    thread.start()
    while slow.process is None and thread.is_alive():
        pass
    with pytest.raises(camopt.BadInput, match="another search is running"):
        slow.run(camopt.find_scene("two-pauses"))
    slow.stop()
    thread.join(10)
    assert answers == [{"why": "the search was stopped"}]


def command(*arguments, folder, **environment):
    line = [sys.executable, "-m", "camopt", "serve", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(
        line, cwd=folder, env={**os.environ, **environment}, preexec_fn=heed_interrupts, **pipes
    )


def heed_interrupts():
    """What runs in the background has its children ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
def test_the_command_prints_the_address_and_ends_well(tmp_path):
    running = command("two-pauses", "--no-browser", "--json", folder=tmp_path)
    try:
        document = "".join(iter(running.stdout.readline, "}\n")) + "}"
        address = urlsplit(json.loads(document)["address"])
        assert address.hostname == "127.0.0.1"
        connection = http.client.HTTPConnection(address.netloc, timeout=20)
        connection.request("GET", address.path)
        assert "Two equal pauses" in connection.getresponse().read().decode()
        connection.close()
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=20)
        assert (running.returncode, out, err) == (0, "", "")
    finally:
        running.kill()
        running.communicate()


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_server_that_is_ended_says_by_what(number, code, tmp_path):
    running = command("two-pauses", "--no-browser", folder=tmp_path)
    assert [running.stdout.readline(), running.stdout.readline()][1] == "Ctrl-C stops the server.\n"
    running.send_signal(number)
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out, err) == (code, "", "")


@pytest.mark.slow
def test_a_browser_is_started_with_an_address_that_works_once(tmp_path):
    """What others see in the list of processes does not let them in."""
    (tmp_path / "browser.py").write_text("import sys; open('seen', 'w').write(sys.argv[1])", encoding="utf-8")
    running = command("two-pauses", folder=tmp_path, BROWSER=f"{sys.executable} {tmp_path / 'browser.py'} %s")
    try:
        token = urlsplit(running.stdout.readline().strip()).path
        while not ((tmp_path / "seen").exists() and (seen := (tmp_path / "seen").read_text(encoding="utf-8"))):
            assert running.poll() is None
        address = urlsplit(seen)
        assert token not in address.path
        answers = []
        for _ in range(2):
            connection = http.client.HTTPConnection(address.netloc, timeout=20)
            connection.request("GET", address.path)
            answer = connection.getresponse()
            answers.append((answer.status, answer.headers["Location"]))
            connection.close()
        assert answers == [(303, token), (403, None)]
    finally:
        running.send_signal(signal.SIGINT)
        running.communicate(timeout=20)
    assert running.returncode == 0


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["two-pauses", "--folder", "nowhere"], 2, "--folder = 'nowhere': must be an existing folder"),
        (["endless.toml"], 2, "nothing limits the size"),
        (["two-pauses", "--port", "TAKEN"], 3, "127.0.0.1:"),
        (["two-pauses", "--port", "70000"], 2, "--port"),
    ],
)
def test_a_server_that_cannot_start_says_why(arguments, code, text, tmp_path):
    endless = camopt.find_scene("knife-300rpm-radial").replace(
        **{"cam.base_radius": None}, search=None, limits=None
    )
    (tmp_path / "endless.toml").write_text(endless.to_toml(), encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        given = [each.replace("TAKEN", str(taken.getsockname()[1])) for each in arguments]
        running = command(*given, "--no-browser", folder=tmp_path)
        out, err = running.communicate(timeout=30)
    assert (running.returncode, out, text in err) == (code, "", True), err


@pytest.fixture(scope="module")
def browser():
    with running_browser() as found:
        yield found


@contextmanager
def page_of(browser, server, **context):
    with watched_page(browser, server.origin, **context) as page:
        page.goto(server.one_time_address)
        page.wait_for_selector("html[data-ready]")
        yield page


def slide(page, key, value):
    """Move a slider as a reader does, and wait until the limits are proved."""
    page.locator(f".control[data-key='{key}'] input[type=range]").evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }", value
    )
    page.wait_for_selector("html[data-state=proved]")


@pytest.mark.slow
def test_a_slider_moves_the_picture_and_all_that_is_said(browser, server):
    with page_of(browser, server) as page:
        outline = page.locator("path.solid").get_attribute("d")
        slide(page, "cam.base_radius", 44)
        assert page.locator("path.solid").get_attribute("d") != outline
        cam = camopt.evaluate(camopt.find_scene("two-pauses").replace(**{"cam.base_radius": 44.0}))
        assert f"{cam['pressure_angle_max_rise_deg']:.4g}°" in page.locator("header").text_content()
        cells = page.locator("#sections td").all_text_contents()
        assert number_text_with_minus_sign(cam["pressure_angle_max_deg"]) in cells
        assert page.input_value("#control-1") == "44"
        page.click("#start")
        page.wait_for_selector("html[data-state=proved]")
        assert page.locator("path.solid").get_attribute("d") == outline


@pytest.mark.slow
def test_the_served_page_prints_whole_without_its_controls(browser, server):
    with page_of(browser, server) as page:
        slide(page, "cam.base_radius", 44)
        with pymupdf.open(stream=page.pdf(format="A4"), filetype="pdf") as printed:
            assert sum(len(sheet.search_for("360°")) for sheet in printed) == page.locator(".diagram").count()
            text = "".join(sheet.get_text() for sheet in printed)
        assert "base radius 44 mm" in text
        assert "Save scene as" not in text


@pytest.mark.slow
def test_of_many_moves_at_once_the_newest_is_asked_alone(browser, server):
    asked = []
    with page_of(browser, server) as page:
        page.on("request", lambda request: asked.append(request.url.rpartition("/")[2]))
        page.locator(".control[data-key='cam.base_radius'] input[type=range]").evaluate(
            """(slider) => {
              for (let k = 20; k <= 60; k++) { slider.value = k; slider.dispatchEvent(new Event("input")); }
            }"""
        )
        page.wait_for_selector("html[data-state=proved]")
        assert asked == ["move", "move", "settle"]
        assert page.evaluate("camopt.values['cam.base_radius']") == 60
        assert "base radius 60 mm" in page.locator("header").text_content()


@pytest.mark.slow
def test_a_bad_value_is_told_beside_its_control_and_the_cam_stays(browser, server):
    with page_of(browser, server) as page:
        outline = page.locator("path.solid").get_attribute("d")
        control = page.locator(".control[data-key='cam.base_radius']")
        for typed, text in (("", "must be a number"), ("-5", "must be at least 1e-09")):
            control.locator("input[type=number]").fill(typed)
            control.locator(".alarm").get_by_text(text).wait_for()
            assert page.locator("path.solid").get_attribute("d") == outline
        control.locator("input[type=number]").fill("52")
        page.wait_for_selector("html[data-state=proved]")
        assert control.locator(".alarm").is_hidden()
        assert page.locator(".stale").count() == 0


@pytest.mark.slow
@pytest.mark.usefixtures("_plainly")
def test_a_linkage_that_cannot_be_assembled_is_shown_as_far_as_it_goes(browser, tmp_path):
    with served("slide-by-bell-crank", tmp_path) as server, page_of(browser, server) as page:
        slider = page.locator(".control[data-key='train.1.offset'] input[type=range]")
        slider.evaluate(
            "(slider) => { slider.max = 120; slider.value = 120; slider.dispatchEvent(new Event('input')); }"
        )
        page.wait_for_selector("html[data-state=refused]")
        assert page.locator("#stage img").is_visible()
        assert page.locator("header .broken").text_content().startswith("the coupler (220 mm) does not reach")
        slide(page, "train.1.offset", -150)
        assert page.locator("#stage img").count() == 0
        assert page.locator("#stage path.solid").count() == 1


@pytest.mark.slow
def test_keys_move_a_slider_and_angles_share_the_turn(browser, server):
    with page_of(browser, server) as page:
        page.locator("summary", has_text="Angles of the turn").click()
        slider = page.locator(".control[data-key='motion.1.angle'] input[type=range]")
        slider.focus()
        page.keyboard.press("ArrowRight")
        page.wait_for_selector("html[data-state=proved]")
        fields = page.locator(".control[data-key^='motion.'] input[type=number]")
        angles = [float(each.input_value()) for each in fields.all()]
        assert angles[0] == 121.0
        assert sum(angles) == pytest.approx(360.0, abs=1e-5)


@pytest.mark.slow
@pytest.mark.usefixtures("_plainly")
def test_the_smallest_cam_moves_the_sliders(browser, tmp_path):
    best = camopt.optimise(camopt.find_scene("knife-300rpm-offset")).best
    with served("knife-300rpm-offset", tmp_path) as server, page_of(browser, server) as page:
        page.click("#smallest")
        page.get_by_text("The smallest cam: proved").wait_for(timeout=60_000)
        page.wait_for_selector("html[data-state=proved]")
        assert float(page.input_value("#control-1")) == pytest.approx(best["base_radius_mm"], rel=1e-7)
        assert "Feasible: the scene gives no limits" in page.locator("header").text_content()


FOREIGN = """async ([page, question]) => {
  const found = {}, body = JSON.stringify({ values: {}, name: "stolen.toml" });
  const tried = {
    read: () => fetch(page),
    "read, opaque": () => fetch(page, { mode: "no-cors" }),
    ask: () => fetch(question, { method: "POST", body, headers: { "Content-Type": "application/json" } }),
    "ask, opaque": () => fetch(question, { method: "POST", body, mode: "no-cors" }),
    "ask, plain": () => fetch(question, { method: "POST", body, headers: { "Content-Type": "text/plain" } }),
  };
  for (const [name, go] of Object.entries(tried)) {
    try { found[name] = (await (await go()).text()).length; } catch { found[name] = "refused"; }
  }
  const frame = document.createElement("iframe");
  const there = new Promise((done) => (frame.onload = done));
  frame.src = page;
  document.body.append(frame);
  await there;
  try { found.frame = frame.contentDocument ? "readable" : "refused"; } catch { found.frame = "refused"; }
  return found;
}"""


@pytest.mark.slow
def test_a_page_of_another_server_on_this_machine_is_told_nothing_even_with_the_token(browser, server, tmp_path):
    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<title>foreign</title>")

        def log_message(self, format, *args):
            pass

    with HTTPServer(("127.0.0.1", 0), Foreign) as other, browser.new_context() as context:
        thread = Thread(target=other.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{other.server_port}/")
        found = page.evaluate(FOREIGN, [server.address, f"{server.address}save"])
        other.shutdown()
        thread.join()
    assert {*found.values()} <= {"refused", 0}
    assert len(found) == 6
    assert [*tmp_path.iterdir()] == []


@pytest.mark.slow
def test_saving_asks_before_it_writes_over_a_file(browser, server, tmp_path):
    path = tmp_path / "Two-equal-pauses-harmonic-rise-parabolic.toml"
    with page_of(browser, server) as page:
        page.get_by_role("button", name="Save", exact=True).click()
        page.get_by_text(f"Saved {path}").wait_for()
        slide(page, "cam.base_radius", 44)
        page.get_by_role("button", name="Save", exact=True).click()
        page.get_by_text("exists already").wait_for()
        assert camopt.find_scene(path) == camopt.find_scene("two-pauses")
        page.get_by_role("button", name="Overwrite").click()
        page.get_by_text(f"Saved {path}").wait_for()
        assert camopt.find_scene(path).cam.base_radius == 44.0
        with page.expect_download() as waiting:
            page.click("#report")
        assert waiting.value.suggested_filename == "Two-equal-pauses-harmonic-rise-parabolic.html"


@pytest.mark.slow
@pytest.mark.usefixtures("_plainly")
@pytest.mark.parametrize("context", [{"viewport": {"width": 390, "height": 800}, "is_mobile": True}, {}])
def test_the_page_is_no_wider_than_its_window_and_names_stay_text(browser, tmp_path, context):
    name = "<img src=x onerror=alert(1)></script><script>alert(2)</script>"
    scene = camopt.find_scene("two-pauses").replace(name=name)
    (tmp_path / "hostile.toml").write_text(scene.to_toml(), encoding="utf-8")
    with served(tmp_path / "hostile.toml", tmp_path) as server, page_of(browser, server, **context) as page:
        slide(page, "cam.base_radius", 44)
        assert page.locator("h1").text_content() == name
        assert page.locator("img").count() == 0
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.slow
@pytest.mark.usefixtures("_plainly")
def test_sliders_change_the_phases_of_a_machine(browser, tmp_path):
    phases = {"knife": 220.0, "film draw": 260.0}
    found = camopt.evaluate_machine(camopt.find_machine("packer").with_phases(phases))
    with served("packer", tmp_path) as server, page_of(browser, server) as page:
        for key, value in phases.items():
            slide(page, key, value)
        peak = f"{found.shaft.largest.value:.6g} N·m"
        assert peak in page.locator("#results").inner_text()
        assert page.evaluate("camopt.data.cams.map(({ shift }) => shift)")[3] == 220.0
        page.locator("#file").fill("mine.toml")
        page.locator("#save button").first.click()
        page.get_by_text("Saved ").wait_for()
    saved = camopt.find_machine(tmp_path / "mine.toml")
    assert {each.name: each.phase for each in saved.station}.items() >= phases.items()
    assert camopt.evaluate_machine(saved).verdict == found.verdict


def test_requests_of_a_machine_are_checked(tmp_path):
    session = MachineSession(camopt.find_machine("packer"), tmp_path)
    for values in ({"nife": 220.0}, {"knife": "x"}):
        answer = answer_request(session, "settle", {"values": values})
        assert [each["key"] for each in answer["mistakes"]] == [*values]
    assert answer_request(session, "move", {"values": {"knife": 200.0}}) == {}
    again = answer_request(session, "save", {"values": {}, "name": "../x.toml"})
    assert "plain file name" in again["mistakes"][0]["text"]
