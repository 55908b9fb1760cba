"""What checks hotlap goes as far as it can on a machine that lacks something, and takes only what is committed for hotlap."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BASH = shutil.which("bash")
TOOLS = ("bash", "dirname", "env")
NOTE = '#!/usr/bin/env bash\necho "$@" >> "$SAID"\n'
AUDIT = f"{NOTE}exit $VULNERABLE\n"
PYTHON = """#!/usr/bin/env bash
[ "$1" = -c ] && exit "$OFFLINE"
mkdir -p "$5" && cp "$6/source" "$5/hotlap.whl"
"""
STAMPS = (".pip", ".groups", ".hotlap", ".supply")


def program(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A clone on a machine that has `make` and little else; gives what runs the pipeline: (exit status, what was made, what was said)."""
    for name in TOOLS:
        (tmp_path / "bin").mkdir(exist_ok=True)
        (tmp_path / "bin" / name).symlink_to(str(shutil.which(name)))
    program(tmp_path / "bin" / "make", NOTE)
    program(tmp_path / "clone" / ".ci" / "run", (ROOT / ".ci" / "run").read_text())
    monkeypatch.setenv("SAID", str(tmp_path / "said"))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("CHROMIUM", str(tmp_path / "bin" / "chromium"))

    def run() -> tuple[int, list[str], str]:
        done = subprocess.run([str(BASH), tmp_path / "clone" / ".ci" / "run"], capture_output=True, text=True, check=False)
        return done.returncode, (tmp_path / "said").read_text().splitlines(), done.stderr

    return run


@pytest.mark.parametrize("apt", [False, True])
def test_without_rights_to_install_a_browser_all_is_done_that_needs_none(machine, tmp_path, apt):
    program(tmp_path / "bin" / "id", "#!/usr/bin/env bash\necho 1000\n")
    if apt:
        program(tmp_path / "bin" / "apt-get", NOTE)
    code, made, said = machine()
    assert (code, made) == (1, ["lint", "venv", "test"])
    assert said.count("\n") == 1
    assert "make check needs chromium fonts-dejavu-core nodejs npm" in said


def test_where_all_is_there_all_is_done(machine, tmp_path):
    for name in ("chromium", "node", "npm"):
        program(tmp_path / "bin" / name, NOTE)
    assert machine() == (0, ["lint", "venv", "test", "check"], "")


@pytest.fixture
def supply(tmp_path, monkeypatch):
    """A repository with an edit that is not committed; gives what runs `make supply`, where a wheel is its source."""
    if not (shutil.which("make") and shutil.which("git")):
        pytest.skip("needs make and git")
    place, tools = tmp_path / "repository", tmp_path / "venv" / "bin"
    place.mkdir()
    shutil.copy(ROOT / "Makefile", place)
    (place / "pyproject.toml").touch()
    (place / "source").write_text("committed")
    monkeypatch.setenv("SAID", str(tmp_path / "said"))
    for key in [key for key in os.environ if key.startswith("GIT_") or key in {"MAKEFLAGS", "MAKELEVEL", "MFLAGS"}]:
        monkeypatch.delenv(key)
    for words in (["init", "-q"], ["add", "."], ["-c", "user.name=x", "-c", "user.email=x@example.org", "commit", "-qm", "x"]):
        subprocess.run(["git", *words], cwd=place, check=True)
    (place / "source").write_text("edited")
    for name, text in (("python", PYTHON), ("uv", NOTE), ("pip-audit", AUDIT)):
        program(tools / name, text)
    for stamp in STAMPS:  # all is installed
        (tools.parent / stamp).touch()

    def run(*, offline: bool = False, vulnerable: bool = False) -> subprocess.CompletedProcess[str]:
        told = {**os.environ, "OFFLINE": str(int(offline)), "VULNERABLE": str(int(vulnerable))}
        asked = ["make", "supply", f"VENV={tools.parent}", f"PYTHON={tools / 'python'}"]
        return subprocess.run(asked, cwd=place, env=told, capture_output=True, text=True, check=False)

    return run


def test_two_wheels_are_of_what_is_committed(supply, tmp_path):
    done = supply()
    assert done.returncode == 0, done.stderr
    assert "two wheels are the same" in done.stdout
    assert {path.read_text() for path in (tmp_path / "repository" / "build" / "wheels").rglob("*.whl")} == {"committed"}


def test_vulnerabilities_are_looked_for_where_somebody_knows_them_and_else_that_is_said(supply, tmp_path):
    assert supply(vulnerable=True).returncode != 0
    assert "--require-hashes" in (tmp_path / "said").read_text()
    done = supply(offline=True, vulnerable=True)
    assert done.returncode == 0
    assert done.stderr == "pypi.org cannot be reached, or does not tell vulnerabilities: none are looked for\n"
