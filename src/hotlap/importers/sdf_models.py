"""Models of SDF: the links and plugins of a vehicle, those of the models that it includes among them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from xml.etree.ElementTree import Element

from hotlap.importers.documents import read_document
from hotlap.importers.markup import Markup
from hotlap.importers.sdf_frames import HERE, Pose, links_of, own_pose

MOST_INCLUDED = 100  # models, of one file and of those that it includes
INCLUDED = re.compile(r"(?:model://)?([\w-][\w.-]*)/?")


@dataclass(frozen=True)
class Parts:
    """What a vehicle is made of.

    Attributes:
        model: the model that was asked for.
        links: by name, with their poses in it.
        plugins: all of them.
        absent: models that are included and were not found.
    """

    model: Markup
    links: dict[str, tuple[Markup, Pose]] = field(default_factory=dict)
    plugins: list[Markup] = field(default_factory=list)
    absent: list[str] = field(default_factory=list)

    @property
    def motors(self) -> list[Markup]:
        """The plugins that drive a rotor."""
        return [plugin for plugin in self.plugins if plugin.first("motorConstant") is not None]


def parts_of(model: Markup, outer: Pose = HERE, chain: tuple[str, ...] = (), included: Iterator[int] | None = None) -> Parts:
    """The parts of a model and of what it includes.

    Args:
        model: an element <model>.
        outer: its pose.
        chain: the files that include it, outermost first.
        included: counts the models that are included.

    Raises:
        InputError: a file that is included cannot be read, or models include one another, or too many.
    """
    included = included or count()
    if model.file in chain:
        raise model.fault("includes itself")
    parts = Parts(model, links_of(model, outer), list(model.all("plugin")))
    for include in model.all("include"):
        if next(included) >= MOST_INCLUDED:
            raise model.fault(f"includes more than {MOST_INCLUDED} models")
        uri = (include.one("uri").element.text or "").strip()
        inner = _included(include.file, uri)
        if inner is None:
            parts.absent.append(uri)
            continue
        found = parts_of(inner, outer.then(own_pose(include)), (*chain, model.file), included)
        prefix = "" if include.element.get("merge") == "true" else f"{_name(include, inner)}::"
        parts.links.update({prefix + name: place for name, place in found.links.items()})
        parts.plugins.extend(found.plugins)
        parts.absent.extend(found.absent)
    return parts


def vehicles_of(document: Markup) -> Iterator[Parts]:
    """The models of a file that have motors."""
    for model in document.within("model"):
        parts = parts_of(model)
        if parts.motors:
            yield parts


def _name(include: Markup, inner: Markup) -> str:
    """What a model is called where it is included."""
    name = include.first("name")
    return inner.name if name is None else (name.element.text or "").strip()


def _included(file: str, uri: str) -> Markup | None:
    """A model from a folder beside the one of the file, if there is one."""
    named = INCLUDED.fullmatch(uri)
    if named is None:
        return None
    folder = Path(file).absolute().parent.parent / named[1]
    try:
        path = next((path for path in (folder / "model.sdf", folder / f"{named[1]}.sdf") if path.is_file()), None)
    except OSError:  # a name that no file can have, a folder that is closed to us
        return None
    root = None if path is None else read_document(path)
    return Markup(str(path), root).first("model") if isinstance(root, Element) else None
