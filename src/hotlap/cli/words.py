"""Words: what a message says in Python, `hotlap.tune(RACE, out='runs/mine')`, as one would type it at a prompt."""

from __future__ import annotations

import ast
import re
import shlex

_CALL = re.compile(r"\bhotlap\.\w+\(")


def as_command(text: str) -> str:
    """A message with commands in place of calls of hotlap: `hotlap tune RACE --out runs/mine`."""
    match = _CALL.search(text)
    if match is None:
        return text
    end = text.find(")", match.end())
    while end >= 0:
        command = _command(text[match.start() : end + 1])
        if command:
            return text[: match.start()] + command + as_command(text[end + 1 :])
        end = text.find(")", end + 1)
    return text[: match.end()] + as_command(text[match.end() :])


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
        words += [f"--{str(given.arg).replace('_', '-')}", ",".join(_words(given.value))]
    return " ".join(words)


def _words(value: ast.expr) -> list[str]:
    """A value as it is typed, several for a list."""
    if isinstance(value, ast.List | ast.Tuple):
        return [word for one in value.elts for word in _words(one)]
    return [shlex.quote(str(value.value)) if isinstance(value, ast.Constant) else ast.unparse(value)]
