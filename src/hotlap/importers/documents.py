"""Documents: TOML, YAML and XML files of others, told apart by what stands in them and read without trust."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, ParseError

import yaml
from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import fromstring

from hotlap.core.errors import InputError
from hotlap.files.bounds import keep_bounds
from hotlap.files.toml_reader import parse
from hotlap.system.regular_files import read_text

MAX_BYTES = 500_000  # the largest description that was met has 50 000


def read_document(path: Path) -> dict[str, Any] | Element:
    """The table of a TOML or YAML file, or the root of an XML file.

    Raises:
        InputError: it cannot be read, is none of them, or is one that could harm.
    """
    text = _text(path)
    try:
        found = _parse_xml(text, path) if text.lstrip().startswith("<") else _parse_table(text, path)
    except RecursionError:
        raise InputError(str(path), "", "is nested too deeply") from None
    if not isinstance(found, Element | dict) or (isinstance(found, dict) and not found):
        raise InputError(str(path), "", "holds no keys: it is neither YAML, TOML nor XML with a description")
    return found if isinstance(found, Element) else keep_bounds(found, str(path))


def _text(path: Path) -> str:
    """A file of text that is not too large."""
    return read_text(path, MAX_BYTES)


def _parse_xml(text: str, path: Path) -> Element:
    try:
        return fromstring(text, forbid_dtd=True)
    except DefusedXmlException:
        raise InputError(str(path), "", "has a document type or entities, which are not read") from None
    except (ParseError, ValueError) as error:
        raise InputError(str(path), "", f"is not valid XML: {error}") from None


def _parse_table(text: str, path: Path) -> Any:
    """The content of a TOML or YAML file; where it is neither, the fault of what its name says."""
    try:
        return parse(text, str(path))
    except ValueError as error:
        fault = f"is not valid TOML: {error}"
    if path.suffix.lower() == ".toml":
        raise InputError(str(path), "", fault)
    try:
        return yaml.load(text, Loader=_PlainLoader)  # noqa: S506  a safe loader
    except (yaml.YAMLError, ValueError) as error:
        raise InputError(str(path), "", f"is not valid YAML: {_one_line(error)}") from None


class _PlainLoader(yaml.SafeLoader):
    """The safe loader, without references, of which a few lines make any amount of data, without tags and keys that are there twice."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """A node; one that repeats another or is to be made something else by a tag is refused."""
        event = self.peek_event()
        odd = "references (*name)" if isinstance(event, yaml.AliasEvent) else "tags (!name)" if getattr(event, "tag", None) else ""
        if odd:
            raise yaml.YAMLError(f"line {event.start_mark.line + 1}: {odd} are not read")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """A table whose keys are all text, as they are written; one that is there twice is refused."""
        keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        for key in keys:
            key.tag = yaml.resolver.BaseResolver.DEFAULT_SCALAR_TAG
        twice = next((key for key, count in Counter(key.value for key in keys).items() if count > 1), None)
        if twice is not None:
            raise yaml.YAMLError(f"line {node.start_mark.line + 1}: {twice} is there twice in one table")
        return super().construct_mapping(node, deep)


def _one_line(error: Exception) -> str:
    """What a parser says, without the picture of the place."""
    mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
    if mark is not None and problem:
        return f"line {mark.line + 1}, column {mark.column + 1}: {problem}"
    return " ".join(str(error).split())
