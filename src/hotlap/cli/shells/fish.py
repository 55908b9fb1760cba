"""Fish: a script that completes."""

from __future__ import annotations

from collections.abc import Iterator

from hotlap.cli.shells.words import Argument, CommandWords

HEAD = """# Completion of hotlap in fish: hotlap completion fish | source
complete -c hotlap -e
complete -c hotlap -f
complete -c hotlap -n __fish_use_subcommand -l version -d 'show the version'
complete -c hotlap -n __fish_use_subcommand -s h -l help -d 'show help'
"""


def script(commands: tuple[CommandWords, ...]) -> str:
    """The script for some commands."""
    return HEAD + "\n".join(line for command in commands for line in _lines(command)) + "\n"


def _lines(command: CommandWords) -> Iterator[str]:
    """A command, what stands without an option, and its options."""
    yield f"complete -c hotlap -n __fish_use_subcommand -a {command.name} -d {_quoted(command.purpose)}"
    within = f"complete -c hotlap -n '__fish_seen_subcommand_from {command.name}'"
    yield f"{within} {_values(command.places)}".rstrip()
    for option in command.options:
        names = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.options)
        takes = f" -r {_values(option)}" if option.metavar else ""
        yield f"{within} {names}{takes.rstrip()} -d {_quoted(option.meaning)}"


def _values(argument: Argument) -> str:
    """What a value may be."""
    words = " ".join(argument.words)
    if argument.folders:
        return "-f -a '(__fish_complete_directories)'"
    if argument.joined:
        return f'-f -a \'(__fish_complete_list , "string split \\" \\" \\"{words}\\"")\''
    return f"{'-F' if argument.files else '-f'}{f' -a {_quoted(words)}' if words else ''}"


def _quoted(text: str) -> str:
    """A text as one word of fish."""
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"
