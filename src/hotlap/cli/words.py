"""Words: what a message says in Python, `hotlap.tune(RACE, out='runs/mine')` or `reference=...`, as one would type it at a prompt."""

from __future__ import annotations

import ast
import re
import shlex

_CALL = re.compile(r"\bhotlap\.\w+\(")
_ARGUMENT = re.compile(r"\b([a-z][a-z_]*)=\.\.\.")


def as_command(text: str) -> str:
    """A message with commands in place of calls of hotlap, `hotlap tune RACE --out runs/mine`, and options in place of arguments."""
    return _ARGUMENT.sub(lambda found: _option(found[1]), _commands(text))


def _commands(text: str) -> str:
    """The same with calls alone."""
    match = _CALL.search(text)
    if match is None:
        return text
    end = text.find(")", match.end())
    while end >= 0:
        command = _command(text[match.start() : end + 1])
        if command:
            return text[: match.start()] + command + _commands(text[end + 1 :])
        end = text.find(")", end + 1)
    return text[: match.end()] + _commands(text[match.end() :])


def _option(name: str) -> str:
    """An argument of a call as the option of a command."""
    return f"--{name.replace('_', '-')}"


def _command(call: str) -> str:
    """One call as a command; "" where it is no call of words and numbers."""
    try:
        parsed = ast.parse(call, mode="eval").body
    except SyntaxError:
        return ""
    if not isinstance(parsed, ast.Call) or not isinstance(parsed.func, ast.Attribute):
        return ""
    words = ["hotlap", parsed.func.attr, *(word for value in parsed.args for word in _words(value))]
    for given in parsed.keywords:
        words += [_option(str(given.arg)), ",".join(_words(given.value))]
    return " ".join(words)


def _words(value: ast.expr) -> list[str]:
    """A value as it is typed, several for a list."""
    if isinstance(value, ast.List | ast.Tuple):
        return [word for one in value.elts for word in _words(one)]
    return [shlex.quote(str(value.value)) if isinstance(value, ast.Constant) else ast.unparse(value)]
