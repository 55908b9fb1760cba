"""The command line as a whole: help, exit codes, purity of standard output, speed of loading."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from hotlap.cli.arguments import COMMANDS, module_of
from hotlap.cli.main import main
from hotlap.core.version import __version__

PROGRAM = [sys.executable, "-m", "hotlap"]
HEAVY = {"numba", "casadi", "matplotlib", "scipy", "sklearn", "numpy", "pydantic", "rich", "cmaes"}


def test_without_arguments_it_says_what_it_can_do(hotlap):
    ran = hotlap()
    assert (ran.code, ran.err) == (0, "")
    assert all(f"\n  {name} " in ran.out for name in COMMANDS)
    assert hotlap("--help") == hotlap("-h") == ran


def test_version(hotlap):
    assert hotlap("--version").out == f"hotlap {__version__}\n"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_even_beside_mistakes(hotlap, name):
    ran = hotlap(name, "--nonsense", "--help")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out.startswith(f"usage: hotlap {name}")
    assert "--json" in ran.out
    assert all(len(line) <= 140 for line in ran.out.splitlines())


def loaded_by(program: str) -> list[set[str]]:
    """The libraries that are there after each line of a program, which runs in a process of its own."""
    lines = ["import sys", *(f"{line}; print('loaded:', *sys.modules, file=sys.stderr)" for line in program.splitlines())]
    ran = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=True)
    return [{name.partition(".")[0] for name in line.split()} for line in ran.stderr.splitlines() if line.startswith("loaded: ")]


def test_help_and_mistakes_load_nothing_that_takes_time():
    calls = (["--help"], ["--version"], *([name, "--help"] for name in COMMANDS), ["tune", "--nonsense"], ["tnue"])
    loaded = loaded_by("from hotlap.cli import main\n" + "\n".join(f"main({call!r})" for call in calls))
    assert len(loaded) == 1 + len(calls)
    assert loaded[-1] & HEAVY == set()


@pytest.mark.check
def test_the_module_of_a_command_loads_nothing_that_flies_plans_or_draws():
    quick = [name for name in COMMANDS if name != "bench"]
    loaded = dict(zip([*quick, "bench"], loaded_by("\n".join(f"import {module_of(name)}" for name in [*quick, "bench"])), strict=True))
    for name, libraries in loaded.items():  # each after those before it
        assert libraries & {"casadi", "matplotlib", "sklearn"} == set(), name
        assert name == "bench" or libraries & {"numba", "scipy"} == set(), name


def test_a_reader_that_goes_away_is_no_error():
    process = subprocess.Popen([*PROGRAM, "races"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait() == 141
    process.stderr.close()


def test_a_reader_that_goes_away_from_an_error_as_json_is_no_error():
    process = subprocess.Popen([*PROGRAM, "tnue", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read().count("\n") == 1
    assert process.wait() == 2
    process.stderr.close()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_disk_behind_standard_output_is_one_line():
    with Path("/dev/full").open("w") as full:
        ran = subprocess.run([*PROGRAM, "races"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (1, "hotlap: standard output: No space left on device\n")


def test_a_terminal_without_our_characters_is_no_error(here, environment):
    (here / "ümlaut.toml").write_text('base = "hummingbird"\nname = "ümlaut"\n', encoding="utf-8")
    ran = subprocess.run(
        [*PROGRAM, "check", "ümlaut.toml"], capture_output=True, check=False, env={**environment, "PYTHONIOENCODING": "ascii"}
    )
    assert (ran.returncode, ran.stderr) == (0, b"")
    assert b"mlaut" in ran.stdout


def test_what_is_wrong_with_the_machine_is_one_line_without_traceback(hotlap, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied", "/somewhere")

    monkeypatch.setattr("hotlap.cli.races.load_race", fail)
    ran = hotlap("races")
    assert (ran.code, ran.out, ran.err) == (1, "", "hotlap: /somewhere: Permission denied\n")


def test_our_own_mistakes_are_not_hidden(monkeypatch):
    monkeypatch.setattr("hotlap.cli.races.load_race", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        main(["races"])
