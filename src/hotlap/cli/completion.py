"""`hotlap completion SHELL`: the script that lets a shell complete."""

from __future__ import annotations

from argparse import Namespace

from hotlap.cli.output import present
from hotlap.cli.shells import bash, fish, zsh
from hotlap.cli.shells.words import commands

SCRIPTS = {"bash": bash.script, "zsh": zsh.script, "fish": fish.script}


def run(options: Namespace) -> int:
    """Print it."""
    script = SCRIPTS[options.shell](commands())
    present(as_json=options.json, document={"shell": options.shell, "script": script}, lines=script.splitlines())
    return 0
