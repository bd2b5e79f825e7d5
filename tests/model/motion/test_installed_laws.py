"""Laws of installed packages: in scenes, sweeps, processes and on a cluster, with no word of them in the parent."""

import json
import os
import subprocess
import sys
from textwrap import dedent

import numpy as np
import pytest

CODE = """
    import numpy as np
    from camopt.model.motion.polynomial import PolynomialLaw

    smooth = PolynomialLaw("smooth", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


    class Gentle:
        TITLE, SOURCE, BREAKS = "3-4-5 polynomial", "a workshop", (0.0, 1.0)

        def displacement(self, x):
            return np.polyval([6.0, -15.0, 10.0, 0.0, 0.0, 0.0], x)

        def velocity(self, x):
            return np.polyval([30.0, -60.0, 30.0, 0.0, 0.0], x)

        def acceleration(self, x):
            return np.polyval([120.0, -180.0, 60.0, 0.0], x)

        def jerk(self, x):
            return np.polyval([360.0, -360.0, 60.0], x)


    class Half(Gentle):
        velocity = None
        del velocity


    class Low(Gentle):
        def displacement(self, x):
            return 0.5 * super().displacement(x)


    class Endless(Gentle):
        def jerk(self, x):
            return np.divide(1.0, np.asarray(x) * 0.0)


    class Backwards(Gentle):
        BREAKS = (0.0, 0.7, 0.3, 1.0)


    class Brief:
        TITLE, SOURCE, BREAKS = "brief", "a workshop", (0.0, 1.0)
        displacement = velocity = acceleration = jerk = staticmethod(lambda x: np.zeros(3))


    gentle, low, endless, backwards, brief = Gentle(), Low(), Endless(), Backwards(), Brief()
"""
ENTRIES = {
    "gentle": "shop_laws:gentle",
    "smooth": "shop_laws:smooth",
    "cycloidal": "shop_laws:gentle",  # a name that camopt has
    "a+b": "shop_laws:gentle",  # what joins names in tables
    "nowhere": "no_such_module:law",
    "nothing": "shop_laws:law",
    "odd": "shop_laws:np",
    "low": "shop_laws:low",
    "endless": "shop_laws:endless",
    "backwards": "shop_laws:backwards",
    "brief": "shop_laws:brief",
}
BROKEN = {
    "nowhere": "fails: ModuleNotFoundError: No module named 'no_such_module'",
    "nothing": "fails: AttributeError: module 'shop_laws' has no attribute 'law'",
    "odd": "lacks TITLE, SOURCE, BREAKS, displacement",
    "low": "must have the displacement 0 at x = 0 and 1 at x = 1",
    "endless": "must give a finite displacement, velocity, acceleration and jerk",
    "backwards": "has BREAKS (0.0, 0.7, 0.3, 1.0), which must rise from 0.0 to 1.0",
    "brief": "must give a finite displacement, velocity, acceleration and jerk for each x",
}
SCENE = """
    import sys

    import camopt

    def scene_of(law, **more):
        table = camopt.find_scene("roller-1000rpm").to_dict()
        for row in table["motion"]:
            row |= {"law": law} if "law" in row else {}
        table["search"] = {"base_radius": [50, 60, 70], "roller_radius": [10, 12]}
        return camopt.Scene.from_dict(table).replace(**more)
"""


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Run a script where a package with laws is installed: what it prints, as JSON."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "shop_laws.py").write_text(dedent(CODE))
    (folder / "shop-2.7.dist-info").mkdir()
    (folder / "shop-2.7.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: shop\nVersion: 2.7\n")
    entries = "\n".join(f"{name} = {place}" for name, place in ENTRIES.items())
    (folder / "shop-2.7.dist-info" / "entry_points.txt").write_text(f"[camopt.laws]\n{entries}\n")

    def run(script):
        command = [sys.executable, "-c", dedent(SCENE) + dedent(script)]
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=False
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_a_law_is_there_by_its_name_and_its_package_is_imported_when_it_is_used(python):
    script = """
        import json
        names, before = [*camopt.LAWS], "shop_laws" in sys.modules
        peak = camopt.LAWS["gentle"].velocity(0.5)
        built_in = camopt.LAWS["cycloidal"].displacement(0.25)
        print(json.dumps([names, before, "shop_laws" in sys.modules, peak, float(built_in)]))
    """
    names, before, after, peak, built_in = python(script)
    assert {"gentle", "smooth", "nowhere"} < {*names}
    assert "a+b" not in names
    assert (before, after, peak) == (False, True, 1.875)
    assert built_in == pytest.approx(0.25 - 1.0 / (2.0 * np.pi), abs=1e-15)


@pytest.mark.slow
def test_it_is_evaluated_certified_and_optimised_as_the_same_law_of_camopt(python):
    script = """
        import json
        found = {}
        for law in ("poly345", "smooth", "gentle"):
            cam = camopt.evaluate(scene_of(law, search={}))
            verdicts = camopt.certify(scene_of(law, search={}))
            best = camopt.optimise(scene_of(law, search={"offset": [0.0]})).best
            numbers = [cam["pressure_angle_max_deg"], cam["jerk_max_m_s3"], best["base_radius_mm"]]
            found[law] = numbers, cam["status"], dict(verdicts), cam["law_rise"]
        print(json.dumps(found))
    """
    found = python(script)
    (numbers, status, verdicts, _), smooth, gentle = found["poly345"], found["smooth"], found["gentle"]
    assert smooth[0] == pytest.approx(numbers, rel=1e-12)
    assert gentle[0] == pytest.approx(numbers, rel=1e-9)
    assert (status, smooth[1], gentle[1]) == ("certified", "certified", "sampled")
    assert smooth[2] == verdicts
    assert {gentle[2][limit] for limit in verdicts} == {"undecided"}
    assert (smooth[3], gentle[3]) == ("smooth", "gentle")


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("engine", ["processes(2)", 'cluster("local", 1)'])
def test_processes_and_workers_of_a_cluster_know_it(python, engine):
    script = f"""
        import json
        from camopt.core.engines import cluster
        from camopt.core.engines.processes import processes

        if __name__ == "__main__":
            found = {{}}
            with {engine} as engine:
                for law in ("gentle", "poly345"):
                    swept = camopt.sweep(scene_of(law), keep="all", engine=engine, block=1)
                    rows = swept.to_pandas("designs")
                    found[law] = rows[["base_radius_mm", "pressure_angle_max_deg"]].to_numpy().tolist()
            print(json.dumps(found))
    """
    found = python(script)
    assert len(found["poly345"]) == 6
    assert np.allclose(found["gentle"], found["poly345"], rtol=1e-9, atol=0.0)


def test_another_version_of_a_package_is_another_question(python):
    script = """
        import json
        from camopt.solve.front.plan import sweep_plan
        plans = [sweep_plan(scene_of(law), "pareto") for law in ("gentle", "poly345")]
        print(json.dumps([plan.sweep_key().version for plan in plans]))
    """
    installed, built_in = python(script)
    assert installed == f"{built_in} shop 2.7"


def test_a_broken_entry_point_is_one_sentence_that_names_its_package(python):
    script = f"""
        import contextlib
        import io
        import json
        from pathlib import Path
        from camopt.cli.main import main

        found = {{}}
        for law in {[*BROKEN]}:
            Path("broken.toml").write_text(scene_of(law, search={{}}).to_toml())
            with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()):
                code = main(["evaluate", "broken.toml"])
            found[law] = code, said.getvalue().splitlines()
        print(json.dumps(found))
    """
    for law, (code, lines) in python(script).items():
        assert len({*lines}) == 1, lines
        line = lines[0]
        assert (code, line.startswith(f"package shop 2.7: entry point {law} of camopt.laws: ")) == (2, True), line
        assert BROKEN[law] in line
