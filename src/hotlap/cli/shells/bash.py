"""Bash: a script that completes; it runs in the version 3.2 of macOS, too."""

from __future__ import annotations

from hotlap.cli.shells.words import Argument, CommandWords

HEAD = """# Completion of hotlap in bash: eval "$(hotlap completion bash)"
_hotlap() {
    local line=${COMP_LINE:0:COMP_POINT} word before command words= files= joined=
    word=${line##* }
    local -a typed
    read -ra typed <<< "${line%"$word"}"
    command=${typed[1]} before=${typed[${#typed[@]}-1]}
"""
FOOT = """    local IFS=$'\\n' head=
    [[ $joined && $word == *,* ]] && head=${word%,*},
    COMPREPLY=($(IFS=' '; compgen -W "$words" -P "$head" -- "${word#"$head"}"))
    if [[ $files ]]; then
        COMPREPLY+=($(compgen -"$files" -- "$word"))
        compopt -o filenames 2> /dev/null  # which the version 3.2 has not
    fi
    local broken=${word%"${word##*[:=]}"}  # what readline does not replace
    COMPREPLY=("${COMPREPLY[@]#"$broken"}")
}
complete -F _hotlap hotlap
"""


def script(commands: tuple[CommandWords, ...]) -> str:
    """The script for some commands."""
    first = " ".join([*(command.name for command in commands), "--help", "--version"])
    lines = ["    if [[ ${#typed[@]} -lt 2 ]]; then", f'        words="{first}"', "    else", "        case $command:$before in"]
    for command in commands:
        lines += [f"            {_case(command, option)}" for option in command.options if option.metavar]
        flags = " ".join(name for option in command.options for name in option.options)
        lines.append(f'            {command.name}:*) if [[ $word == -* ]]; then words="{flags}"; else {_values(command.places)}; fi ;;')
    return HEAD + "\n".join([*lines, "        esac", "    fi"]) + "\n" + FOOT


def _case(command: CommandWords, option: Argument) -> str:
    """What follows an option."""
    names = "|".join(f"{command.name}:{name}" for name in option.options)
    return f"{names}) {_values(option)} ;;"


def _values(argument: Argument) -> str:
    """What a value may be."""
    words = " ".join(argument.words)
    parts = [f'words="{words}"'] if words else []
    parts += ["files=f"] if argument.files else ["files=d"] if argument.folders else []
    return "; ".join([*parts, *(["joined=1"] if argument.joined else [])]) or ":"
