"""`hotlap completion`: what the shells that are here complete, asked of them."""

from __future__ import annotations

import shlex
import shutil
import subprocess

import pytest

from hotlap.cli.arguments import COMMANDS, SHELLS
from hotlap.files.descriptions import Kind, names

# A line, some of what completes its last word, and something that does not.
LINES = {
    "hotlap ": ({"tune", "check", "cache", "completion"}, "circle-34"),
    "hotlap ch": ({"check"}, "tune"),
    "hotlap tune circle-3": ({"circle-34"}, "circle-20"),
    "hotlap tune circle-34 --bud": ({"--budget"}, "--batch"),
    "hotlap tune circle-34 --tuner gate_g": ({"gate_gp", "gate_gp:tied"}, "cma_es"),
    "hotlap tune circle-34 --tuner gate_gp:ti": ({"gate_gp:tied"}, "gate_gp:whole"),
    "hotlap compare circle-34 --tuners gate_gp,cma_es:bi": ({"gate_gp,cma_es:bipop"}, "cma_es:bipop"),
    "hotlap new race mine --track spl": ({"split-s"}, "circle"),
    "hotlap new race mine --vehicle three": ({"three-inch"}, "five-inch"),
    "hotlap fly circle-34 --on rot": ({"rotorpy"}, "airsim"),
    "hotlap check humm": ({"hummingbird"}, "circle"),
    "hotlap plan my-r": ({"my-race.toml"}, "circle-34"),
    "hotlap fly circle-34 --reference my-r": ({"my-race.toml"}, "circle-34"),
    "hotlap report run": ({"runs/"}, "my-race.toml"),
    "hotlap tuners gate_gp:t": ({"gate_gp:tied"}, "gate_gp:whole"),
    "hotlap quadrotors x5": ({"x500"}, "three-inch"),
    "hotlap compare --races def": ({"default"}, "all"),
    "hotlap compare circle-34 --clu": ({"--cluster"}, "--confirm"),
    "hotlap learn circle-34 --cluster my-r": ({"my-race.toml"}, "circle-34"),
    "hotlap completion z": ({"zsh"}, "bash"),
}
ASK_BASH = "source ./script; COMP_LINE={line}; COMP_POINT=${{#COMP_LINE}}; _hotlap; printf '%s\\n' \"${{COMPREPLY[@]}}\""
ASK_FISH = "source ./script; complete -C {line}"
ASK_ZSH = """
compdef() {{ : }}
_describe() {{ local -a given=(${{(P)@[-1]}}); print -l -- ${{given%%:*}} }}
_files() {{ print -l -- *(N) }}
_message() {{ : }}
compset() {{ [[ $PREFIX == *,* ]] && {{ IPREFIX=${{PREFIX%,*}},; PREFIX=${{PREFIX##*,}} }} }}
compadd() {{ while [[ $1 != -- ]]; do shift; done; shift; print -l -- $IPREFIX${{^@}} }}
source ./script
line={line}
words=(${{(z)line}}); [[ $line == *' ' ]] && words+=('')
CURRENT=$#words PREFIX=$words[-1] IPREFIX=
_hotlap
"""


def ask(shell, line, here):
    """What a shell completes a line to."""
    (here / "my-race.toml").touch()
    (here / "runs").mkdir(exist_ok=True)
    question = {"bash": ASK_BASH, "fish": ASK_FISH, "zsh": ASK_ZSH}[shell].format(line=shlex.quote(line))
    program = [shell, *(["--norc", "--noprofile"] if shell == "bash" else ["--no-config"] if shell == "fish" else ["-f"]), "-c", question]
    ran = subprocess.run(program, cwd=here, capture_output=True, text=True, check=False, timeout=60)
    assert ran.stderr == ""
    return {found.partition("\t")[0] for found in ran.stdout.splitlines()}


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_completes(hotlap, here, shell, line):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    (here / "script").write_text(hotlap("completion", shell).out)
    wanted, unwanted = LINES[line]
    word = line.rpartition(" ")[2]
    broken = word[: max(word.rfind(":"), word.rfind("=")) + 1] if shell == "bash" else ""  # what readline leaves as it is
    found = {one.removesuffix("/") for one in ask(shell, line, here)}
    assert {one.removeprefix(broken).removesuffix("/") for one in wanted} <= found
    if shell != "zsh":  # which chooses among what it is given by itself
        assert unwanted not in found


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_race_quadrotor_and_option_is_there(hotlap, shell):
    script = hotlap("completion", shell).out
    every = [*COMMANDS, *(name for kind in Kind for name in names(kind))]
    flags = {option for name, command in COMMANDS.items() for option in command.parser(name).options if option.startswith("--")}
    every += [f"-l {flag[2:]} " if shell == "fish" else flag for flag in flags]
    assert [word for word in every if word not in script] == []


def test_a_shell_that_is_not_known_is_told_which_are(hotlap):
    ran = hotlap("completion", "csh")
    assert (ran.code, ran.out) == (2, "")
    assert "available: bash, fish, zsh" in ran.err


def test_as_json(hotlap):
    document = hotlap("completion", "bash", "--json").document
    assert document == {"shell": "bash", "script": hotlap("completion", "bash").out}
