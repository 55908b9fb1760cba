"""Damage: what a disk, a network or a hand may do to a file, drawn from a random generator of one's own."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Sequence
from random import Random
from typing import Any

ODD_NUMBERS = (
    *(b"0", b"-0.0", b"-1", b"1e200", b"-1e200", b"1e308", b"1e309", b"1e-320", b"nan", b"inf", b"-inf", b"NaN", b"Infinity"),
    *(b"9223372036854775808", b"1" * 400, b"0x7f", b"1_0", b"1.5.2", b"+", b"1,5"),
)
ODD_WORDS = (
    *(b"", b'""', b"true", b"null", b"[]", b"{}", b"[[[[]]]]", b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", "\u202eü\u0000".encode()),
    *(b"\r\n", b"\n\n", b"'", b'"', b'"""', b"[", b"]", b"{", b"}", b"=", b".", b",", b"#", b"<", b">", b"&a", b"*a", b"!!int", b": "),
    *(b"[" * 300, b"a." * 150, b"/dev/zero", b"../" * 40, b"~nobody/x", b"a" * 700, b"%s%n", b"$(touch fuzz)", b"__import__('os')"),
)
ODD_VALUES: tuple[Any, ...] = (
    *(None, True, "", "x", "a\nb", "1e5", 0, -1, 10**18, 10**30, 1e200, -1e200, 1e308, 1e-320, math.nan, math.inf, -0.0),
    *([], {}, [[]], [1, "a"], [math.nan] * 3, [0.0] * 3, [1e308] * 3, [1.0] * 4, {"a": 1}, [{}], [[[[0]]]], ["x"] * 50, b"x"),
)
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e-?\d+)?")
_WORD = re.compile(rb"\w+")


def damage(data: bytes, random: Random, others: Sequence[bytes] = ()) -> bytes:
    """Data after one to four accidents.

    Args:
        data: as it was.
        random: draws the accidents.
        others: of which pieces may come in.
    """
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        data = random.choice(_ACCIDENTS)(data, random, others or (data,))
    return data


def _flip(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    """A few bits."""
    changed = bytearray(data)
    for _ in range(random.choice((1, 1, 3, 30)) if data else 0):
        changed[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return bytes(changed)


def _cut(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    return data[: random.randint(0, len(data))]


def _drop(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    start, end = _range(data, random)
    return data[:start] + data[end:]


def _repeat(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    start, end = _range(data, random)
    return data[:end] + data[start:end] * random.choice((1, 2, 20)) + data[end:]


def _clear(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    """A piece that was never written."""
    start, end = _range(data, random)
    return data[:start] + bytes(end - start) + data[end:]


def _splice(data: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    other = random.choice(others)
    start, end = _range(other, random)
    place = random.randint(0, len(data))
    return data[:place] + other[start:end] + data[place:]


def _renumber(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    return _replaced(data, random, _NUMBER, ODD_NUMBERS)


def _reword(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    return _replaced(data, random, _WORD, ODD_WORDS)


def _insert(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    place = random.randint(0, len(data))
    return data[:place] + random.choice(ODD_WORDS + ODD_NUMBERS) + data[place:]


def _shuffle_lines(data: bytes, random: Random, _: Sequence[bytes]) -> bytes:
    lines = data.split(b"\n")
    i, j = random.randrange(len(lines)), random.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def _replaced(data: bytes, random: Random, pattern: re.Pattern[bytes], words: Sequence[bytes]) -> bytes:
    found = list(pattern.finditer(data[:20_000]))
    if not found:
        return data
    one = random.choice(found)
    return data[: one.start()] + random.choice(words) + data[one.end() :]


def _range(data: bytes, random: Random) -> tuple[int, int]:
    start = random.randint(0, len(data))
    return start, min(len(data), start + random.choice((1, 4, 40, 400, 4000)))


_ACCIDENTS = (_flip, _cut, _drop, _repeat, _clear, _splice, _renumber, _renumber, _reword, _reword, _insert, _shuffle_lines)


def disturb(value: Any, random: Random) -> Any:
    """Plain JSON with an odd value, without a key, or with one more, somewhere in it."""
    changed = copy.deepcopy(value)
    for _ in range(random.choice((1, 1, 2))):
        places = list(_places(changed))
        if not places:
            return random.choice(ODD_VALUES)
        holder, key = random.choice(places)
        what = random.random()
        if what < 0.15:
            del holder[key]
        elif what < 0.25 and isinstance(holder, dict):
            holder[f"{key}x"] = holder[key]
        elif what < 0.35 and isinstance(holder, list):
            holder.insert(key, copy.deepcopy(holder[key]))
        else:
            holder[key] = copy.deepcopy(random.choice(ODD_VALUES))
    return changed


def _places(value: Any) -> Any:
    """Every (table or list, key or index) within a value."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield value, key
            yield from _places(item)
