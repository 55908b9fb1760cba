"""Zsh: a script that completes, to be evaluated, or kept as `_hotlap` in a folder of $fpath."""

from __future__ import annotations

from hotlap.cli.shells.words import Argument, CommandWords

HEAD = """#compdef hotlap
# Completion of hotlap in zsh: eval "$(hotlap completion zsh)"
_hotlap() {
    local -a found
    if (( CURRENT == 2 )); then
"""
FOOT = """    esac
}
if [[ $funcstack[1] == _hotlap ]]; then
    _hotlap "$@"
else
    (( $+functions[compdef] )) || { autoload -Uz compinit && compinit }
    compdef _hotlap hotlap
fi
"""


def script(commands: tuple[CommandWords, ...]) -> str:
    """The script for some commands."""
    first = " ".join(_described(command.name, command.purpose) for command in commands)
    lines = [f"        found=({first} {_described('--help', 'show help')} {_described('--version', 'show the version')})"]
    lines += ["        _describe command found", "        return", "    fi", "    case $words[2]:$words[CURRENT-1] in"]
    for command in commands:
        lines += [f"        {_case(command, option)}" for option in command.options if option.metavar]
        flags = " ".join(_described(name, option.meaning) for option in command.options for name in option.options)
        lines.append(f"        ({command.name}:*) if [[ $PREFIX == -* ]]; then found=({flags}); _describe -o option found")
        lines.append(f"            else {_values(command.places)}; fi ;;")
    return HEAD + "\n".join(lines) + "\n" + FOOT


def _case(command: CommandWords, option: Argument) -> str:
    """What follows an option."""
    names = "|".join(f"{command.name}:{name}" for name in option.options)
    return f"({names}) {_values(option)} ;;"


def _values(argument: Argument) -> str:
    """What a value may be."""
    words = " ".join(argument.words)
    parts = [f"compset -P '*,'; compadd -S '' -- {words}" if argument.joined else f"compadd -- {words}"] if words else []
    parts += ["_files"] if argument.files else ["_files -/"] if argument.folders else []
    return "; ".join(parts) or f"_message '{argument.metavar}'"


def _described(word: str, meaning: str) -> str:
    """A word with its meaning, quoted."""
    quoted = meaning.replace("'", "'\\''")
    return f"'{word}:{quoted}'"
