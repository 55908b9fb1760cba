"""Interface: the public names and the modules of hotlap, found by looking, so that none is forgotten."""

from __future__ import annotations

import pkgutil
import re
from importlib import import_module

from sphinx.application import Sphinx

import hotlap

NAMES = "<!-- public names -->"
MODULES = re.compile(r"<!-- modules: ([\w. ]+) -->")


def names() -> str:
    """A row for each public name: what it is, where it is described."""
    rows = [f"| {link(name)} | {first_sentence(getattr(hotlap, name))} |" for name in hotlap.__all__]
    return "\n".join(["| name | |", "|---|---|", *rows])


def link(name: str) -> str:
    """A reference to where a name is described."""
    described = getattr(hotlap, name)
    return f"{{py:obj}}`{name} <{described.__module__}.{name}>`"


def first_sentence(described: object) -> str:
    """The first sentence of a docstring, on one line."""
    text = " ".join((described.__doc__ or "").split("\n\n", 1)[0].split())
    return text.replace("|", "\\|")


def modules(package: str) -> list[str]:
    """A package's own description, and each of its modules that is not a package itself."""
    found = pkgutil.iter_modules(import_module(package).__path__, f"{package}.")
    inside = [module.name for module in found if not module.ispkg and not module.name.rpartition(".")[2].startswith("_")]
    return [package, *inside]


def expanded(names: str) -> list[str]:
    """Modules by name; `name.` with its dot behind stands for a package with all its modules."""
    found = [module for name in names.split() for module in (modules(name[:-1]) if name.endswith(".") else [name])]
    return list(dict.fromkeys(found))


def section(module: str) -> str:
    """A module with all that it defines."""
    options = ("members", "ignore-module-all", "exclude-members: model_config")
    shown = "\n".join(f"   :{option}" if ": " in option else f"   :{option}:" for option in options)
    return f"## {module}\n\n```{{eval-rst}}\n.. automodule:: {module}\n{shown}\n```\n"


def fill(_: Sphinx, __: str, source: list[str]) -> None:
    """Put names and modules where a page asks for them."""
    if NAMES in source[0]:
        source[0] = source[0].replace(NAMES, names())
    source[0] = MODULES.sub(lambda match: "\n".join(map(section, expanded(match[1]))), source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Fill pages as they are read."""
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
