"""The base of every description that can be written as TOML: frozen, checked, unknown keys refused."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from hotlap.core.shown import Shown

Vector3 = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
LARGEST = 1e5  # m: a size or coordinate beyond this is a mistake of units
Coordinate = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Size = Annotated[float, Field(gt=0, le=LARGEST)]
Thickness = Annotated[float, Field(ge=0, le=LARGEST)]


class Described(Shown, BaseModel):
    """A frozen description with checked keys; NaN and infinity are refused.

    The docstring below a key is its documentation: the unit in brackets, then its meaning. Tables, templates and error messages show it.
    """

    renamed: ClassVar[Mapping[str, str]] = {}
    """Former names of keys, which files may still use, and their present names."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    @property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that change whenever a value changes."""
        text = json.dumps(self.model_dump(mode="json"), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]
