"""The kernels' cache on disk: what is damaged is compiled anew, and what cannot be written is no trouble."""

import ast
import os
import stat
import subprocess
import sys
from pathlib import Path
from time import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camopt.core.kernels import kernel_cache
from camopt.core.kernels.arguments import NUMBER, kernel_argument_type
from camopt.core.kernels.compile import NEVER_COMPILE, Kernel
from camopt.core.kernels.kernel_cache import (
    DIGEST_SIZE,
    UNUSED_SECONDS,
    KernelFile,
    kernel_cache_root,
    open_version_folder,
)
from camopt.core.kernels.machine_code import ObjectCode, target_system_cpu_and_features
from camopt.core.kernels.version import KERNEL_FOLDERS

PACKAGE = Path(kernel_cache.__file__).parents[2]


def total(values, result):
    result[0] = 0.0
    for value in values:
        result[0] += value


VALUES, RESULT = np.arange(5.0), np.empty(1)
KINDS = kernel_argument_type(VALUES), kernel_argument_type(RESULT)
compiles = pytest.mark.skipif(NEVER_COMPILE, reason="nothing is compiled")


def is_loaded_from(folder):
    """A new kernel with its file in a folder, called once: whether its machine code came from there."""
    kernel = Kernel(total)
    kernel.files[KINDS] = KernelFile(total, KINDS, folder)
    kernel(VALUES, RESULT)
    assert RESULT[0] == 10.0
    return "dispatcher" not in vars(kernel)


@compiles
def test_machine_code_is_kept(tmp_path):
    assert [is_loaded_from(tmp_path) for _ in range(3)] == [False, True, True]
    (file,) = tmp_path.iterdir()
    assert file.suffix == ".kernel"


DAMAGE = {
    "emptied": lambda data: b"",
    "cut in the digest": lambda data: data[:7],
    "cut in half": lambda data: data[: len(data) // 2],
    "without its end": lambda data: data[:-1],
    "zeros, as after a power cut": lambda data: bytes(len(data)),
    "a bit flipped at the start": lambda data: bytes([data[0] ^ 1]) + data[1:],
    "a bit flipped inside": lambda data: (
        data[: DIGEST_SIZE + 500] + bytes([data[DIGEST_SIZE + 500] ^ 64]) + data[DIGEST_SIZE + 501 :]
    ),
    "its digest alone": lambda data: data[:DIGEST_SIZE],
}


@compiles
@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_damaged_is_compiled_and_written_anew(tmp_path, damage):
    is_loaded_from(tmp_path)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.write_bytes(DAMAGE[damage](whole))
    assert not is_loaded_from(tmp_path)
    assert is_loaded_from(tmp_path)
    assert list(tmp_path.iterdir()) == [file]


names = st.text("abz_09", min_size=1)


@given(name=names, content=st.binary(max_size=300), data=st.data())
def test_every_flipped_bit_and_every_cut_is_seen(tmp_path_factory, name, content, data):
    file, code = KernelFile(total, KINDS, tmp_path_factory.mktemp("kernels")), ObjectCode(name, content)
    file.write(code)
    assert file.read() == code
    whole = file._file.read_bytes()
    bit = data.draw(st.integers(0, 8 * len(whole) - 1))
    flipped = bytearray(whole)
    flipped[bit // 8] ^= 1 << bit % 8
    for damaged in (bytes(flipped), whole[: data.draw(st.integers(0, len(whole) - 1))]):
        file._file.write_bytes(damaged)
        assert file.read() is None


def test_a_file_of_something_else_is_none(tmp_path):
    file, other = (KernelFile(total, kinds, tmp_path) for kinds in (KINDS, (NUMBER,)))
    other.write(ObjectCode("total", b"code"))
    other._file.rename(file._file)
    assert file.read() is None


@compiles
@pytest.mark.parametrize(
    "trouble", [OSError(28, "No space left on device"), PermissionError(13, "Permission denied")]
)
def test_a_disk_that_takes_nothing_is_no_trouble(tmp_path, monkeypatch, trouble):
    def full(*_, **__):
        raise trouble

    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_bytes", full)
        assert [is_loaded_from(tmp_path) for _ in range(2)] == [False, False]
        assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(Path, "mkdir", full)
    assert not is_loaded_from(open_version_folder(tmp_path / "new", "0" * 16))


@compiles
@pytest.mark.parametrize("relative", [False, True])  # as platformdirs says it, and as it said it before
def test_a_user_without_a_home_keeps_nothing(tmp_path, monkeypatch, relative):
    def homeless(name):
        if relative:
            return Path("~/.cache") / name
        raise RuntimeError("could not determine the home directory")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernel_cache, "user_cache_path", homeless)
    folder = open_version_folder(kernel_cache_root(""), "0" * 16)
    assert [is_loaded_from(folder) for _ in range(2)] == [False, False]
    assert folder == kernel_cache.NO_FOLDER
    assert not [*tmp_path.iterdir()]
    assert kernel_cache_root("named") == Path("named")


@compiles
def test_a_folder_in_place_of_a_file_is_no_trouble(tmp_path):
    is_loaded_from(tmp_path)
    (file,) = tmp_path.iterdir()
    file.unlink()
    file.mkdir()
    assert not is_loaded_from(tmp_path)


def test_the_processor_is_the_one_that_numba_compiles_for():
    from numba.core.registry import cpu_target

    assert target_system_cpu_and_features() == cpu_target.target_context.codegen().magic_tuple()


@compiles
def test_another_processor_has_files_of_its_own(tmp_path, monkeypatch):
    is_loaded_from(tmp_path)
    monkeypatch.setattr(kernel_cache, "target_system_cpu_and_features", lambda: ("another", "processor", ""))
    assert not is_loaded_from(tmp_path)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_new_folder_is_private(tmp_path, capsys):
    folder = open_version_folder(tmp_path / "root", "0" * 16)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert open_version_folder(tmp_path / "root", "0" * 16) == folder
    assert capsys.readouterr().err == ""


def opened_wide(folder, monkeypatch):
    folder.chmod(0o755)


def change_owner(folder, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: folder.stat().st_uid + 1)


def linked_from_elsewhere(folder, monkeypatch):
    folder.rename(folder.with_name("elsewhere"))
    folder.symlink_to("elsewhere")


@compiles
@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="folders have no modes")
@pytest.mark.parametrize("change", [opened_wide, change_owner, linked_from_elsewhere])
def test_code_in_a_folder_of_others_is_not_run(change, tmp_path, monkeypatch, capsys):
    folder = open_version_folder(tmp_path, "0" * 16)
    is_loaded_from(folder)
    before = [*folder.iterdir()]
    change(folder, monkeypatch)
    refused = open_version_folder(tmp_path, "0" * 16)
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"camopt: {folder} is not used: it must be your folder, with mode 0700"
    assert [is_loaded_from(refused) for _ in range(2)] == [False, False]
    assert [*folder.iterdir()] == before


def test_folders_of_versions_long_unused_go(tmp_path):
    old, recent, other = tmp_path / ("a" * 16), tmp_path / ("b" * 16), tmp_path / "not-a-version"
    for folder in (old, recent, other):
        folder.mkdir()
        (folder / "file").touch()
    for folder, age in ((old, 1.1 * UNUSED_SECONDS), (recent, 0.9 * UNUSED_SECONDS), (other, 9 * UNUSED_SECONDS)):
        os.utime(folder, (time() - age,) * 2)
    (tmp_path / ("d" * 16)).symlink_to(other)
    assert open_version_folder(tmp_path, "c" * 16).is_dir()
    assert sorted(path.name[0] for path in tmp_path.iterdir()) == ["b", "c", "d", "n"]
    assert (other / "file").exists()
    os.utime(recent, (time() - 9 * UNUSED_SECONDS,) * 2)
    recent.chmod(0o700)
    assert open_version_folder(tmp_path, "b" * 16) == recent  # its use keeps it
    assert open_version_folder(tmp_path, "e" * 16).is_dir()
    assert recent.is_dir()


@pytest.mark.long  # it compiles twice; kernels alone are tested above
def test_a_command_survives_a_torn_cache(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    compiling = "from camopt.core.kernels.compile_rule import compile_at_first_call; compile_at_first_call()"
    main = f"{compiling}; from camopt.cli.main import main; raise SystemExit(main())"
    command = [sys.executable, "-c", main, "sweep", "roller-1000rpm", "--quiet", "--out"]

    def swept_table(folder):
        run = subprocess.run([*command, folder], capture_output=True, text=True, timeout=600, env=environment)
        assert (run.returncode, run.stderr) == (0, "")
        return pq.read_table(folder / "designs.parquet")

    first = swept_table(tmp_path / "first")
    files = list(tmp_path.rglob("*.kernel"))
    for file in files:
        file.write_bytes(b"")
    assert swept_table(tmp_path / "second").equals(first)
    assert bool(files) == ("NUMBA_DISABLE_JIT" not in os.environ)
    assert all(file.stat().st_size for file in files)


# ------------------------------------------------------------------------ what the folder's name depends on

MESSAGES = "camopt.core.mistakes"  # reaches no kernel
MARKING = {"camopt.core.kernels.compile", "camopt.core.kernels.marks"}


def modules_of(path):
    """The modules of the package that a file imports, and whether it has to do with the compiler."""
    names, compiler = set(), False
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        found = [node.module] if isinstance(node, ast.ImportFrom) else []
        found += [f"{node.module}.{alias.name}" for alias in node.names] if isinstance(node, ast.ImportFrom) else []
        found += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        compiler |= any(name.split(".")[0] == "numba" or name in MARKING for name in found)
        names |= {name for name in found if name.startswith("camopt")}
    return names, compiler


def file_of(name):
    path = PACKAGE.parent / name.replace(".", "/")
    return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.exists()), None)


def test_kernels_are_made_of_nothing_outside_their_folders():
    """Modules with compiled functions, and all that they import: an edit of any changes the cache's folder."""
    folders = tuple(PACKAGE / folder for folder in KERNEL_FOLDERS)
    sources = [path for path in PACKAGE.rglob("*.py") if modules_of(path)[1]]
    reached = set(sources)
    assert len(reached) > 10
    waiting = list(reached)
    while waiting:
        for name in modules_of(waiting.pop())[0] - {MESSAGES}:
            path = file_of(name)
            if path is not None and path not in reached:
                reached.add(path)
                waiting.append(path)
    outside = [path for path in reached if not any(map(path.is_relative_to, folders))]
    assert outside == []
