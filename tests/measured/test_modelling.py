"""cvxpy is imported without scipy.stats, which is there all the same for whoever asks."""

import subprocess
import sys

PROGRAMME = """
import sys
from camopt.measured.modelling import cp
assert "cvxpy" in sys.modules and "scipy.stats" not in sys.modules
from cvxpy.atoms.quantum_rel_entr import entropy
assert abs(entropy([0.5, 0.5]) - 0.6931471805599453) < 1e-15
import scipy.stats
assert scipy.stats.norm.cdf(0.0) == 0.5
x = cp.Variable(2)
print(round(cp.Problem(cp.Minimize(cp.norm(x - 3.0)), [x <= 2.0]).solve(solver=cp.CLARABEL), 6))
"""

ASKED_MEANWHILE = """
import sys
from camopt.measured import modelling

def asks(name):
    import scipy.stats
    assert scipy.stats.norm.cdf(0.0) == 0.5
    return real(name)

sys.modules.pop("cvxpy")
real, modelling.import_module = modelling.import_module, lambda name: (asks if name == "cvxpy" else real)(name)
modelling.imported_quickly()
import scipy.stats
print(type(scipy.stats).__name__, sys.modules["scipy.stats"] is scipy.stats)
"""


def said(programme):
    command = [sys.executable, "-c", programme]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def test_cvxpy_solves_without_statistics_and_statistics_are_there_when_asked_for():
    assert said(PROGRAMME) == "1.414214"


def test_what_is_asked_of_statistics_while_cvxpy_is_imported_is_answered():
    assert said(ASKED_MEANWHILE) == "module True"
