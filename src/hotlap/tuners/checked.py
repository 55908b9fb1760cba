"""Checked: a tuner of someone else's, whose every answer is checked against the protocol before anything depends on it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from traceback import extract_tb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError, InputError
from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.tuner import Tuner

METHODS = ("start", "ask", "tell", "state", "restore")
SETTINGS = "its settings must be a frozen dataclass of numbers, booleans, strings and tuples of these"


def checked(tuner: Tuner) -> Tuner:
    """A tuner whose answers are checked; hotlap's own are as they are, since their tests check them."""
    return tuner if type(tuner).__module__.startswith("hotlap.") else Checked(tuner)


def made(make: Callable[[str, Any], Any], name: str, settings: Any) -> Tuner:
    """A tuner of a class of someone else's, checked.

    Args:
        make: the class.
        name: that the tuner is to bear.
        settings: of its preset.

    Raises:
        InputError: it cannot be made, or is no tuner.
    """
    check_settings(name, settings)
    with _faults(name, "__init__"):
        tuner = make(name, settings)
    missing = [method for method in METHODS if not callable(getattr(tuner, method, None))]
    if missing:
        raise _fault(name, f"has no {', '.join(missing)}; a tuner has the methods {', '.join(METHODS)}")
    lacking = [key for key in ("name", "settings") if not hasattr(tuner, key)]
    if lacking:
        raise _fault(name, f"has no attribute {lacking[0]}; it keeps what it is made with: MyTuner(name, settings)")
    check_settings(name, tuner.settings)
    return checked(tuner)


def check_settings(name: str, settings: Any) -> None:
    """Refuse settings that a study cannot keep.

    Raises:
        InputError: with the field and its type.
    """
    if isinstance(settings, type) or not is_dataclass(settings):
        raise _fault(name, f"{SETTINGS}, not {_shown(settings)}")
    for field in fields(settings):
        where = _unplain(getattr(settings, field.name), field.name)
        if where is not None:
            raise _fault(name, f"{SETTINGS}; {where}")


class Checked:
    """A tuner that answers as another one does, or says in one line how that one's answer breaks the protocol.

    Args:
        tuner: not yet started.
    """

    def __init__(self, tuner: Tuner) -> None:
        self.name = str(getattr(tuner, "name", "") or f"{type(tuner).__module__}.{type(tuner).__qualname__}")
        self._tuner, self.settings = tuner, getattr(tuner, "settings", None)

    def __getattr__(self, key: str) -> Any:
        """Whatever else the tuner has, such as `learns_from_any` or `report`."""
        if key.startswith("__") or key == "_tuner":
            raise AttributeError(key)
        found = getattr(self._tuner, key)
        return {"ask_together": self._ask_together, "recommend": self._recommend}.get(key, found)

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """As the tuner."""
        self._space, self._shape = space, first_guess.shape
        with _faults(self.name, "start"):
            self._tuner.start(first_guess, space, rng)

    def ask(self, n: int) -> Parameters:
        """As the tuner: 1 to n candidates of the right shape, within the bounds."""
        with _faults(self.name, "ask"):
            asked = self._tuner.ask(n)
        return self._candidates("ask", asked, n, least=1)

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """As the tuner: a truth value for each candidate."""
        with _faults(self.name, "tell"):
            accepted = self._tuner.tell(parameters, scores)
        wanted, told = (len(parameters),), _array(accepted)
        if told is None or told.shape != wanted or not np.isin(told, (0, 1)).all():
            raise _fault(self.name, f"tell must return which candidates it accepts, {wanted} truth values, not {_shown(accepted)}")
        return told.astype(np.bool_)

    def state(self) -> dict[str, Any]:
        """As the tuner: plain JSON."""
        with _faults(self.name, "state"):
            state = self._tuner.state()
        if not isinstance(state, dict):
            raise _fault(self.name, f"state must return a dict of plain JSON, not {_shown(state)}")
        where = _unplain(state, "")
        if where is not None:
            raise _fault(self.name, f"state must return plain JSON: {where}")
        return state

    def restore(self, state: dict[str, Any]) -> None:
        """As the tuner."""
        with _faults(self.name, "restore"):
            self._tuner.restore(state)

    def _ask_together(self, count: int) -> Parameters:
        """As the tuner: 1 to count candidates."""
        with _faults(self.name, "ask_together"):
            asked = self._tuner.ask_together(count)  # pyright: ignore[reportAttributeAccessIssue]  it has one
        return self._candidates("ask_together", asked, count, least=1)

    def _recommend(self, count: int, rng: np.random.Generator) -> Parameters:
        """As the tuner: at most count candidates."""
        with _faults(self.name, "recommend"):
            asked = self._tuner.recommend(count, rng)  # pyright: ignore[reportAttributeAccessIssue]  it has one
        return self._candidates("recommend", asked, count, least=0)

    def _candidates(self, method: str, asked: Any, most: int, least: int) -> Parameters:
        """Candidates, shape (B, S, K) with least <= B <= most, that lie within the bounds.

        Raises:
            InputError: they do not.
        """
        found, (segments, size) = _array(asked), self._shape
        wanted = f"{least} to {most} candidates of {segments} segments and {size} parameters"
        if found is None or found.ndim != 3 or found.shape[1:] != self._shape:
            if not least and found is not None and not found.size:
                return np.empty((0, *self._shape))
            raise _fault(self.name, f"{method}({most}) must return {wanted}, shape (B, {segments}, {size}), not {_shown(asked)}")
        if not least <= len(found) <= most:
            raise _fault(self.name, f"{method}({most}) must return {wanted}, not {len(found)}")
        within = (found >= self._space.low) & (found <= self._space.high)
        if not within.all():
            i, segment, k = np.argwhere(~within)[0].tolist()
            bounds = f"{self._space.low[k]:g} to {self._space.high[k]:g}"
            key = f"{self._space.names[k]} = {found[i, segment, k]:g} in segment {segment + 1}"
            raise _fault(self.name, f"{method} gave {key}, beyond its bounds of {bounds}; space.clip brings candidates within them")
        return found.astype(np.float64)


def _array(value: Any) -> NDArray[Any] | None:
    """Numbers or truth values as an array; None where it is something else."""
    try:
        found = np.asarray(value)
    except ValueError:
        return None
    return found if found.dtype.kind in "biuf" else None


def _unplain(value: Any, where: str) -> str | None:
    """What in a value is not plain JSON, and where; None where all of it is."""
    name = where or "it"
    if value is None or isinstance(value, str | bool | int):
        return None
    if isinstance(value, float):
        return None if math.isfinite(value) else f"{name} is {value}, for which JSON has no number (None would do)"
    if isinstance(value, Mapping) and isinstance(value, dict):
        named = next((key for key in value if not isinstance(key, str)), None)
        if named is not None:
            return f"{name} has the key {named!r}, and keys are strings"
        parts = ((one, f"{where}[{key!r}]" if where else str(key)) for key, one in value.items())
        return next((fault for one, place in parts if (fault := _unplain(one, place)) is not None), None)
    if isinstance(value, list | tuple):
        return next((fault for i, one in enumerate(value) if (fault := _unplain(one, f"{where}[{i}]")) is not None), None)
    cure = (
        "; .tolist() makes it one" if isinstance(value, np.ndarray) else "; .item() makes it one" if isinstance(value, np.generic) else ""
    )
    return f"{name} is {_shown(value)}{cure}"


def _shown(value: Any) -> str:
    """A value in a message: its type, and its shape where it has one."""
    if value is None:
        return "None"
    found = _array(value) if isinstance(value, np.ndarray | list | tuple) else None
    kind = f"{type(value).__module__}.{type(value).__name__}" if isinstance(value, np.ndarray | np.generic) else type(value).__name__
    return f"a {kind}" + ("" if found is None else f" of shape {found.shape}")


def _fault(name: str, reason: str) -> InputError:
    return InputError("", "tuner", f"{name}: {reason}")


@contextmanager
def _faults(name: str, method: str) -> Iterator[None]:
    """Whatever a method raises, as one line with the place in its file; the original is its cause."""
    try:
        yield
    except HotlapError:
        raise
    except Exception as error:  # code of someone else's may raise anything
        reason = " ".join(str(error).split())
        frames = [frame for frame in extract_tb(sys.exc_info()[2]) if frame.filename != __file__]
        place = f" ({Path(frames[0].filename).name}, line {frames[0].lineno})" if frames else ""
        raise _fault(name, f"{method} raised {type(error).__name__}{f': {reason}' if reason else ''}{place}") from error
