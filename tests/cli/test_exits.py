"""How commands end: exit codes that mean one thing each, one line for what went wrong, streams that are closed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from camopt.cli import exits
from camopt.cli.main import camopt, main
from camopt.core.mistakes import BadInput, Mistake, Stopped, escape_unprintable
from camopt.core.storage.files import expand_user_path
from camopt.solve.tables.cells import column_heading

ESCAPE = "\x1b[31mred\x1b[0m\nsecond line\u202e"


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def shell(command, **environment):
    """A command line of bash, in which camopt is this one: exit code, standard output, standard error."""
    line = f'camopt() {{ "{sys.executable}" -m camopt "$@"; }}; {command}'
    variables = {**os.environ, **environment}
    done = subprocess.run(["bash", "-c", line], capture_output=True, timeout=300, env=variables)
    out, err = (text.decode(errors="replace") for text in (done.stdout, done.stderr))
    assert "Traceback" not in err
    assert "Exception ignored" not in err
    return done.returncode, out, err


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("command", ["laws --quiet", "laws --quiet --json", "scenes two-pauses", "--help"])
def test_a_pipe_without_a_reader_has_a_code_of_its_own(command):
    assert shell(f"camopt {command} | head -c0; exit ${{PIPESTATUS[0]}}") == (exits.READER_GONE, "", "")


@pytest.mark.one_in(2)
@pytest.mark.parametrize("stream", ["2>&-", "2>/dev/full"])
def test_a_closed_stderr_leaves_the_exit_code_and_the_output(stream):
    assert shell(f"camopt evaluate nowhere {stream}") == (exits.BAD_INPUT, "", "")
    code, out, _ = shell(f"camopt scenes two-pauses {stream}")
    assert (code, "[cam]" in out) == (0, True)


@pytest.mark.slow
def test_a_closed_stdout_is_no_trouble_and_a_full_one_is():
    assert shell("camopt laws >&-") == (0, "", "")
    assert shell("camopt laws >/dev/full") == (exits.FILE_TROUBLE, "", "camopt: No space left on device\n")


@pytest.mark.slow
def test_a_closed_stderr_gives_its_number_to_no_file():
    code, out, _ = shell("camopt evaluate two-pauses --points c.csv 2>&-", NUMBA_DISABLE_JIT="1")
    assert (code, "wrote" in out) == (0, False)
    assert Path("c.csv").read_text(encoding="utf-8").startswith('"cam_angle_deg",')


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("value", ["0", "-1", "many"])
def test_an_environment_that_numba_refuses_is_told_in_a_line(value):
    code, out, err = shell(
        "camopt accuracy roller-1000rpm", NUMBA_NUM_THREADS=value, NUMBA_DISABLE_JIT="0", NUMBA_CACHE_DIR="empty"
    )
    assert (code, out, err.count("\n")) == (exits.BAD_INPUT, "", 1)
    assert "numba does not start with its environment variables" in err


@pytest.mark.slow
def test_a_sweep_needs_no_numba():
    code, _, err = shell(
        "camopt sweep roller-1000rpm --quiet --out out", NUMBA_NUM_THREADS="0", NUMBA_CACHE_DIR="empty"
    )
    assert (code, err) == (0, "")


@pytest.fixture
def ends(monkeypatch, capsys):
    """End a command with an exception: exit code and standard error."""

    def call(end):
        def command(ctx):
            raise end

        monkeypatch.setattr(camopt, "invoke", command)
        code = main(["laws"])
        return code, capsys.readouterr().err

    return call


@pytest.mark.parametrize(
    "fault", [KeyError("size"), ZeroDivisionError("a\nb"), RecursionError(), EOFError(), AssertionError()]
)
def test_a_fault_of_the_program_is_told_in_a_line_with_a_code_of_its_own(ends, fault):
    code, err = ends(fault)
    assert (code, err.strip().count("\n")) == (exits.INTERNAL_ERROR, 0)
    assert "internal error (" in err
    assert type(fault).__name__ in err
    assert "please report it" in err


def test_a_fault_is_placed_in_the_file_of_the_package_where_it_is(capsys):
    assert (
        exits.run_command(lambda: column_heading(3.5)) == exits.INTERNAL_ERROR
    )  # in a folder beside that of the command line
    assert "internal error (cells.py, line" in capsys.readouterr().err


def test_the_traceback_of_a_fault_is_there_for_those_who_ask(ends, monkeypatch):
    monkeypatch.setenv(exits.DEBUG_VARIABLE, "1")
    assert "Traceback" in ends(KeyError("size"))[1]


@pytest.mark.parametrize(
    ("end", "code"),
    [
        (KeyboardInterrupt(), 130),
        (Stopped(), 130),
        (BrokenPipeError(32, "Broken pipe"), exits.READER_GONE),
        (PermissionError(13, "Permission denied", "here"), exits.FILE_TROUBLE),
        (MemoryError(), exits.FILE_TROUBLE),
        (OSError(), exits.FILE_TROUBLE),
        (OSError("no library\nas said on a page"), exits.FILE_TROUBLE),
        (ImportError("failed to map segment", path="/x/numpy.so"), exits.FILE_TROUBLE),
        (ImportError("cannot import name"), exits.INTERNAL_ERROR),
    ],
)
def test_each_end_has_its_code(ends, end, code):
    found, err = ends(end)
    assert (found, err.strip().count("\n")) == (code, 0)


def test_no_code_means_two_things():
    codes = {name: value for name, value in vars(exits).items() if name.isupper() and isinstance(value, int)}
    assert len(set(codes.values())) == len(codes)


@pytest.mark.parametrize("field", ["file", "key", "value", "allowed"])
def test_messages_are_one_line_of_printable_characters(field):
    fields = {"file": "f", "key": "k", "value": "v", "allowed": "a", field: ESCAPE}
    text = str(BadInput([Mistake(**fields)]))
    assert text.isprintable()
    assert "second line" in text
    assert escape_unprintable("Größe μ ∞ 凸轮") == "Größe μ ∞ 凸轮"


# --------------------------------------------------------------------------- paths, before the work

WORK = ["sweep", "--base-radius", "90", "--offset", "0", "--roller-radius", "5", "--law", "harmonic"]


@pytest.fixture
def run(capsys, monkeypatch):
    """Run a command that must not come to its work: exit code and standard error."""

    def call(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert out == ""
        return code, err

    return call


@pytest.mark.parametrize("address", ["s3://b/t", "gs://b", "file:///tmp/x", "https://example.org/x"])
@pytest.mark.parametrize(
    "command", [[*WORK, "--out"], ["synthesise", "--out"], ["evaluate", "two-pauses", "--plot"]]
)
def test_addresses_are_no_paths(run, command, address):
    code, err = run(*command, address)
    assert (code, list(Path().iterdir())) == (exits.BAD_INPUT, [])
    assert "must be a path on this machine, not an address" in err


@pytest.mark.parametrize("command", ["synthesise", "frontier", "accuracy"])
def test_a_folder_that_takes_no_files_is_found_out_before_the_work(run, command, monkeypatch):
    def work(*arguments, **options):
        raise AssertionError("the work has begun")

    for home, name in (
        ("solve.synthesis.synthesise", "synthesise"),
        ("solve.synthesis.frontier", "frontier"),
        ("show.studies.accuracy", "measure_accuracy_costs"),
    ):
        monkeypatch.setattr(f"camopt.{home}.{name}", work)
    code, err = run(command, "--out", "/proc/nothing/inside")
    assert code == exits.FILE_TROUBLE
    assert err.startswith("camopt: /proc/nothing")


@pytest.mark.parametrize("option", ["--points", "--plot"])
def test_a_file_that_cannot_be_written_is_found_out_before_the_scene_is_read(run, option):
    suffix = "csv" if option == "--points" else "png"
    assert run("evaluate", "no-such-scene", option, f"nowhere/c.{suffix}")[0] == exits.FILE_TROUBLE
    Path(f"taken.{suffix}").mkdir()
    code, err = run("evaluate", "no-such-scene", option, f"taken.{suffix}")
    assert (code, err) == (exits.FILE_TROUBLE, f"camopt: taken.{suffix}: Is a directory\n")
    assert run("evaluate", "no-such-scene", option, "c.xyz")[0] == exits.BAD_INPUT


def test_a_pipe_is_no_part_of_a_sweep(run):
    os.mkfifo("pipe")  # which nobody writes to: to open it would take for ever
    code, err = run("merge", "pipe")
    assert (code, "must be a folder with parts of a sweep; this has none" in err) == (exits.BAD_INPUT, True)


def test_a_tilde_is_the_home_folder(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert main([*WORK, "--out=~/cams", "--quiet"]) == 0
    assert sorted(path.name for path in (tmp_path / "cams").iterdir()) == [
        ".camopt",
        "designs.parquet",
        "manifest.json",
        "pareto.parquet",
        "scene.toml",
    ]
    assert main([*WORK, "--out=~nobody44/cams"]) == exits.BAD_INPUT
    assert "its home folder is not known" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["./~", "./~/cams", "sub/../~", "./~root"])
def test_a_tilde_after_a_dot_is_a_folder_of_that_name(folder, monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "work" / "sub").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "work")
    assert main([*WORK, f"--out={folder}", "--quiet"]) == 0
    assert (tmp_path / "work" / folder / "pareto.parquet").is_file()
    assert main(["evaluate", "two-pauses", "--plot", f"{folder}/cam.svg", "--quiet"]) == 0
    assert (tmp_path / "work" / folder / "cam.svg").is_file()
    assert main(["new", f"{folder}/cam.toml"]) == 0
    assert (tmp_path / "work" / folder / "cam.toml").is_file()
    written = (tmp_path / "home").rglob("*")
    assert [path for path in written if path.suffix in (".parquet", ".toml", ".svg")] == []


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("~", "HOME"),
        ("~/a", "HOME/a"),
        ("./~", "CWD/~"),
        ("./~/a", "CWD/~/a"),
        (".//~", "CWD/~"),
        ("a/~", "a/~"),
        ("/~", "/~"),
        ("../~", "../~"),
        ("a~", "a~"),
    ],
)
def test_only_a_path_that_begins_with_a_tilde_is_in_the_home_folder(text, path, monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    found = expand_user_path(text)
    assert str(found) == path.replace("HOME", str(tmp_path / "home")).replace("CWD", os.getcwd())
    assert expand_user_path(found) == found


def test_an_interrupt_of_an_import_is_told_as_one():
    code = (
        "import sys\n"
        "class Interrupt:\n"
        "    def find_spec(self, name, *where):\n"
        "        if name == 'camopt.cli.exits': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupt())\n"
        "from camopt.__main__ import main\n"
        "sys.exit(main())\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (run.returncode, run.stdout, run.stderr) == (130, "", "camopt: interrupted\n")


@pytest.mark.slow
def test_a_home_that_takes_nothing_is_no_trouble():
    nowhere = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"), "/proc/nothing")
    code, _, err = shell("camopt evaluate two-pauses --plot c.png", **nowhere, NUMBA_DISABLE_JIT="1")
    assert (code, err) == (0, "wrote c.png\n")
