"""The floor of the warm sweep: processes that import its libraries, write its table of designs, and do no more.

    python benchmarks/libraries.py [RUNS]

The table of designs of ``camopt sweep --rpm 1000 --max-pressure 30`` is made first, and put into a file whose bytes
are those of memory. Then each case is a process of its own, in turns: the least and the median of wall times, and
both over those of a process that imports numpy.
"""

import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

import pyarrow as pa
import pyarrow.parquet as pq

import camopt
from camopt.tables.table import parquet_options

LIBRARIES = "import click, pydantic, numpy, moocore, rich.table; from llvmlite import binding; pydantic.BaseModel"
"""All but pyarrow, which a thread imports."""
WRITTEN = """
def write():
    import pyarrow as pa, pyarrow.parquet as pq
    from hashlib import sha256
    table = pa.ipc.open_file(pa.memory_map("designs.arrow")).read_all()
    with open("floor.parquet", "w+b") as whole:
        digest = sha256()
        with pa.OSFile("floor.parquet", "wb") as file, pq.ParquetWriter(file, table.schema, {options}) as parquet:
            for first in range(0, table.num_rows, {rows}):
                parquet.write_table(table.slice(first, {rows}))
                digest.update(whole.read())
        os.fsync(whole.fileno())
"""
BESIDE = """import os, threading
{work}
thread = threading.Thread(target=write)
thread.start()
{libraries}
thread.join()
"""
IMPORTED = "def write():\n    import pyarrow.parquet"


def cases(layout: pa.Schema, rows: int) -> dict[str, str]:
    """What processes do, by name."""
    options = {"compression": "zstd", "write_page_checksum": True, **parquet_options(layout)}
    written = WRITTEN.format(options=", ".join(f"{key}={value!r}" for key, value in options.items()), rows=rows)
    return {
        "nothing": "",
        "numpy": "import numpy",
        "the libraries but pyarrow": LIBRARIES,
        "all libraries": BESIDE.format(work=IMPORTED, libraries=LIBRARIES),
        "and the table of designs": BESIDE.format(work=written, libraries=LIBRARIES),
    }


def main(runs: int) -> None:
    with TemporaryDirectory() as name:
        folder = Path(name)
        scene = camopt.find_scene("roller-1000rpm").replace(**{"cam.rpm": 1000, "limits.pressure_angle": 30})
        camopt.sweep(scene, out=folder)
        table = pq.read_table(folder / "designs.parquet").combine_chunks()
        with pa.ipc.new_file(folder / "designs.arrow", table.schema) as file:
            file.write_table(table)
        groups = pq.read_metadata(folder / "designs.parquet").row_group(0).num_rows
        found = cases(table.schema, groups)
        environment = {**os.environ, "PYDANTIC_DISABLE_PLUGINS": "__all__", "OPENBLAS_NUM_THREADS": "1"}
        times: dict[str, list[float]] = {name: [] for name in found}
        for _ in range(runs):
            for name, code in found.items():
                start = perf_counter()
                subprocess.run([sys.executable, "-P", "-c", code], cwd=folder, env=environment, check=True)
                times[name].append(1e3 * (perf_counter() - start))
    print("| a process that imports | least, ms | median, ms | times numpy |\n|---|---:|---:|---:|")
    for name, each in times.items():
        least, middle = (of(each) for of in (min, median))
        ratios = " / ".join(f"{of(each) / of(times['numpy']):.2f}" for of in (min, median))
        print(f"| {name} | {least:.0f} | {middle:.0f} | {ratios} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 20)
