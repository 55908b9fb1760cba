"""Of the working folder, which may be anybody's, no code runs but what the user has named, and that is said."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hotlap.cli.main import main
from hotlap.core import own_code
from hotlap.core.own_code import OwnCode, import_own

TUNER = """
from support_of_a_test import PRESETS
from hotlap.tuners.random_search import RandomSearch

class Mine(RandomSearch):
    pass
"""
OPTIONAL = (
    "yaml cffi colorama coverage cython Cython pandas psutil lz4 optuna IPython dask jax cupy torch mujoco rotorpy msgpack polars pyarrow"
)
NEEDED = "numpy scipy numba llvmlite casadi pydantic cmaes matplotlib rich sklearn joblib PIL threadpoolctl typing_extensions"
MARK = "import pathlib\nwith pathlib.Path({!r}).open('a') as mark:\n    mark.write(__name__ + ' ')\nraise ImportError(__name__)\n"
PROGRAM = "import sys\nfrom hotlap.cli import main\nif __name__ == '__main__':\n    sys.exit(main())\n"
SAID = pytest.mark.filterwarnings("default::hotlap.core.own_code.OwnCode")  # as for a user, not as an error
FLY = ["fly", "circle-34", "--flights", "2"]


@pytest.fixture
def own_tuner(here):
    """A tuner in the working folder, with a module that it needs."""
    (here / "tuner_of_a_test.py").write_text(TUNER)
    (here / "support_of_a_test.py").write_text("from hotlap.tuners.random_search import PRESETS\n")
    yield here / "tuner_of_a_test.py"
    for name in ("tuner_of_a_test", "support_of_a_test"):
        sys.modules.pop(name, None)


@SAID
@pytest.mark.usefixtures("faked")
def test_a_tuner_of_the_working_folder_runs_and_that_is_said_once(hotlap, own_tuner):
    path = list(sys.path)
    ran = hotlap("tune", "straight.toml", "--tuner", "tuner_of_a_test.Mine", "--budget", "3", "--validation", "0", "--out", "mine")
    assert ran.code in {0, 1}
    assert ran.err.count(f"hotlap: runs code of {own_tuner}\n") == 1
    assert "warning" not in ran.err
    assert sys.path == path


def test_what_is_not_there_is_one_line(hotlap):
    ran = hotlap("tune", "straight.toml", "--tuner", "no_such_tuner_of_a_test.Mine")
    assert (ran.code, ran.err.count("\n")) == (2, 1)
    assert "runs code" not in ran.err


@SAID
def test_a_simulator_of_the_working_folder_is_named_too(hotlap, own_tuner):
    ran = hotlap("fly", "straight.toml", "--on", "tuner_of_a_test.No")
    assert ran.code == 2
    assert f"runs code of {own_tuner}" in ran.err


def test_the_folder_is_on_the_path_during_that_import_alone(here, monkeypatch):
    (here / "one_of_a_test.py").write_text("import sys\nPATH = list(sys.path)\nraise ZeroDivisionError\n")
    path = list(sys.path)
    with pytest.warns(OwnCode, match="one_of_a_test"), pytest.raises(ZeroDivisionError):
        import_own("one_of_a_test")
    assert sys.path == path
    monkeypatch.setattr(own_code, "parent_process", lambda: "a parent, who has said it")
    with pytest.raises(ZeroDivisionError):
        import_own("one_of_a_test")
    assert sys.path == path


@pytest.mark.filterwarnings("ignore::hotlap.core.own_code.OwnCode")
def test_what_a_module_does_to_the_path_itself_stays(here, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    path = [*sys.path]
    (here / "path_of_a_test.py").write_text("import os, sys\nsys.path.insert(0, '/a/library')\nsys.path.append(os.getcwd())\n")
    import_own("path_of_a_test")
    sys.modules.pop("path_of_a_test")
    assert sys.path == ["/a/library", *path, str(here)]


def test_what_is_installed_comes_first(here):
    (here / "rich.py").write_text("1 / 0")
    (here / "colorsys.py").write_text("1 / 0")
    assert import_own("rich.console").__name__ == "rich.console"
    assert not import_own("colorsys").__file__.startswith(str(here))


def test_a_package_of_the_working_folder_is_found(here):
    (here / "package_of_a_test").mkdir()
    (here / "package_of_a_test" / "__init__.py").write_text("")
    (here / "package_of_a_test" / "inner.py").write_text("VALUE = 3")
    with pytest.warns(OwnCode, match="package_of_a_test"):
        assert import_own("package_of_a_test.inner").VALUE == 3
    for name in ("package_of_a_test", "package_of_a_test.inner"):
        sys.modules.pop(name)


@pytest.fixture
def attacked(tmp_path):
    """A folder full of modules that hotlap, or what it needs, may look for; each says that it ran, in the file that is given."""
    mark, folder = tmp_path / "mark", tmp_path / "folder"
    folder.mkdir()
    for name in (OPTIONAL + " " + NEEDED).split():
        (folder / f"{name}.py").write_text(MARK.format(str(mark)))
    (folder / ".numba_config.yaml").write_text("disable_jit: 1\n")
    (folder / "matplotlibrc").write_text("backend: module://cython\n")
    (tmp_path / "hotlap").write_text(PROGRAM)
    return folder, mark


def standard_library(folder, mark):
    """Modules of Python's own as well; what Python reads before it runs a program cannot be helped."""
    for name in sys.stdlib_module_names:
        if not (folder / f"{name}.py").exists():
            (folder / f"{name}.py").write_text(MARK.format(str(mark)))


def run_in(folder, *arguments):
    """Run a program there, without the path of the tests."""
    environment = {**os.environ, "PYTHONPATH": str(Path(own_code.__file__).parents[2])}
    environment.pop("PYTHONSAFEPATH", None)
    ran = subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert "Traceback" not in ran.stderr
    return ran


@pytest.fixture(scope="module")
def warm():
    """Plan and kernel are there."""
    assert main(FLY) == 0


@pytest.mark.check
@pytest.mark.usefixtures("warm")
def test_nothing_of_the_working_folder_runs(attacked):
    folder, mark = attacked
    standard_library(folder, mark)
    assert run_in(folder, str(folder.parent / "hotlap"), *FLY).returncode == 0
    assert not mark.exists()


@pytest.mark.check
@pytest.mark.usefixtures("warm")
def test_nor_where_python_looks_there_first(attacked):
    folder, mark = attacked
    assert run_in(folder, "-m", "hotlap", *FLY).returncode == 0
    assert not mark.exists()


@pytest.mark.check
@pytest.mark.usefixtures("warm")
def test_nor_by_any_other_command_nor_in_its_workers(attacked):
    folder, mark = attacked
    standard_library(folder, mark)
    program = str(folder.parent / "hotlap")
    for command in (
        "check drop-20 --flights 4",
        "plan drop-20 --out plan.csv",
        "fly circle-34 --flights 2 --first-guess paper",
        "tune drop-20 --tuner random_search --budget 6 --validation 0 --out study",
        "export study --format optuna --out study.db",
        "report study --figures",
        "compare drop-20 --tuners random_search,cma_es --budget 4 --seeds 2 --out runs",
    ):
        ran = run_in(folder, program, *command.split())
        assert ran.returncode in {0, 1}, (command, ran.stderr)
        assert not mark.exists(), (command, mark.read_text())
    for name in sys.stdlib_module_names:
        (folder / f"{name}.py").unlink(missing_ok=True)
    again = "compare drop-20 --tuners random_search --budget 4 --seeds 2 --out again"
    assert run_in(folder, "-m", "hotlap", *again.split()).returncode == 0
    assert not mark.exists()
