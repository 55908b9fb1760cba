"""Numba starts without loading scipy.linalg, and multiplies matrices all the same; settings of the working folder change nothing."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import sys
from hotlap.system.numba_start import start_numba
start_numba()
start_numba()
import numba, numpy as np

@numba.njit
def triple(a):
    return np.vdot(a[0], a[0]) + (a @ a).sum()

print("scipy.linalg" in sys.modules, triple(2.0 * np.eye(3)), "scipy.linalg" in sys.modules)
start_numba()
"""


@pytest.mark.check
def test_matrices_are_multiplied_by_a_library_that_is_loaded_then():
    ran = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["False", "16.0", "True"]


SETTINGS = """
import sys, warnings
warnings.simplefilter("error")
if sys.argv[1] == "algebra":
    import scipy.linalg.cython_blas
if sys.argv[1] == "yaml":
    import yaml
known = sys.modules.get("yaml")
from hotlap.system.numba_start import start_numba
start_numba()
import numba
assert sys.modules.get("yaml") is known
double = numba.njit(lambda x: x + x)
print(double(2), hasattr(double, "signatures") and len(double.signatures))
"""


@pytest.mark.parametrize(("loaded", "settings"), [("nothing", "disable_jit: 1"), ("algebra", "- no: table"), ("yaml", "*: [")])
def test_settings_of_the_working_folder_change_nothing(tmp_path, loaded, settings):
    (tmp_path / ".numba_config.yaml").write_text(settings)
    ran = subprocess.run([sys.executable, "-P", "-c", SETTINGS, loaded], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["4", "1"]
