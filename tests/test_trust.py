"""Nothing in the source runs what a file says: no pickle, no unsafe YAML, no evaluation; one place imports code of the working folder."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

import hotlap

ROOT = Path(hotlap.__file__).parent
FORBIDDEN_MODULES = {"shelve", "marshal", "dill", "cloudpickle", "joblib", "jsonpickle", "code", "codeop", "imp", "runpy", "lxml"}
FORBIDDEN_CALLS = {
    *("eval", "exec", "compile", "__import__", "execfile"),
    *("pickle.load", "pickle.loads", "pickle.Unpickler", "os.system", "os.popen", "os.execv", "pty.spawn", "np.fromregex"),
    *("yaml.full_load", "yaml.unsafe_load", "yaml.load_all", "yaml.Loader", "yaml.UnsafeLoader", "yaml.FullLoader"),
    *("read_pickle", "tempfile.mktemp", "ast.literal_eval"),
}
ALLOWED = {
    ("flight/kernel_cache.py", "pickle.loads"): "Numba's cache is pickle: sealed files in a folder of one's own",
    ("system/cluster_worker.py", "pickle.loads"): "messages between the user and workers of the user's own cluster, which --cluster names",
    ("system/process_pool.py", "pickle.loads"): "what this process has just pickled itself",
}
IMPORTS_BY_NAME = {  # where a name that is computed is imported
    "core/own_code.py": "a tuner or a simulator that the user has named, which is said",
    "__init__.py": "names of hotlap's own",
    "cli/main.py": "modules of commands",
    "cli/tuners.py": "modules of tuners",
    "exporters/__init__.py": "modules of formats",
    "logs/packages.py": "packages that read logs",
    "real_flight/__init__.py": "modules of vehicles",
    "reproduce/experiments.py": "modules of experiments",
    "tuners/__init__.py": "modules of tuners",
    "worlds/__init__.py": "modules of worlds",
    "system/numba_start.py": "modules of Numba",
}


@cache
def trees() -> dict[str, ast.Module]:
    """Every file of the source by its path."""
    return {path.relative_to(ROOT).as_posix(): ast.parse(path.read_text(encoding="utf-8")) for path in sorted(ROOT.rglob("*.py"))}


def calls() -> list[tuple[str, str, ast.Call]]:
    """(file, what is called, the call)."""
    found = [(file, node) for file, tree in trees().items() for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return [(file, ast.unparse(node.func), node) for file, node in found]


def keyword(node: ast.Call, name: str) -> str | None:
    return next((ast.unparse(given.value) for given in node.keywords if given.arg == name), None)


def test_what_runs_a_files_content_is_called_nowhere_else():
    found = {(file, what) for file, what, _ in calls() if what in FORBIDDEN_CALLS or what.rpartition(".")[2] in {"eval", "read_pickle"}}
    assert found == set(ALLOWED)


def test_no_module_is_imported_that_does():
    found = set()
    for file, tree in trees().items():
        for node in ast.walk(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            found |= {(file, name) for name in names if name.partition(".")[0] in FORBIDDEN_MODULES}
    assert found == set()


def test_arrays_are_read_without_pickle():
    reads = [(file, node) for file, what, node in calls() if what in {"np.load", "numpy.load"}]
    assert len(reads) >= 3
    assert {keyword(node, "allow_pickle") for _, node in reads} == {"False"}


def test_yaml_is_read_by_a_loader_that_makes_plain_values_alone():
    reads = [(file, keyword(node, "Loader")) for file, what, node in calls() if what == "yaml.load"]
    assert reads == [("importers/documents.py", "_PlainLoader")]
    (loader,) = (node for node in ast.walk(trees()["importers/documents.py"]) if isinstance(node, ast.ClassDef) and "Loader" in node.name)
    assert [ast.unparse(base) for base in loader.bases] == ["yaml.SafeLoader"]


def test_modules_are_imported_by_name_where_names_are_known():
    found = set()
    for file, what, node in calls():
        if what.rpartition(".")[2] == "import_module" and not isinstance(node.args[0], ast.Constant):
            found.add(file)
    assert found == set(IMPORTS_BY_NAME)


def test_the_path_of_modules_is_changed_in_one_place():
    changed = {file for file, what, _ in calls() if what.startswith(("sys.path.", "site.addsitedir"))}
    assert changed == {"core/own_code.py"}


def test_no_process_goes_through_a_shell():
    assert [(file, what) for file, what, node in calls() if keyword(node, "shell") not in {None, "False"}] == []


@pytest.mark.parametrize("ending", [".part", ".tmp", ".temp", ".bak"])
def test_parts_of_files_are_named_in_one_place(ending):
    texts = {file for file, tree in trees().items() for node in ast.walk(tree) if isinstance(node, ast.Constant) and node.value == ending}
    assert texts <= {"system/whole_files.py"}


def test_the_compiler_is_started_by_the_flight_core_alone():
    """Which takes no settings from the working folder."""
    found = set()
    for file, tree in trees().items():
        for node in tree.body:
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            found |= {file.partition("/")[0] for name in names if name.partition(".")[0] in {"numba", "llvmlite"}}
    assert found == {"flight"}
