"""Descriptions: tracks, quadrotors, races and tuned parameters, read from and written to TOML files.

No other package reads files of a user but for references and imports; an error is one line with the file, the key and the reason.
A description may build on another (`base = "circle-34"`), and a race refers to its track and quadrotors by name, by path or
by a table. Whatever is referred to is read and checked by itself first.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files as package_files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.renamed import say_renamed
from hotlap.files import toml_writer
from hotlap.files.documented_keys import table_of
from hotlap.files.error_messages import check, show
from hotlap.files.kinds import Kind
from hotlap.files.parameters_file import SavedParameters
from hotlap.files.recognition import TYPES, kind_by_keys, refuse_description, refuse_other_kind, refuse_parameters, strangers
from hotlap.files.toml_reader import ELSEWHERE, read
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.race.schema import Described
from hotlap.race.track import Track
from hotlap.system.regular_files import is_there, oddity
from hotlap.system.text_files import cause_of, replace

Description = Track | Quadrotor | Race

PARAMETERS_FILE = "parameters.toml"  # in a study's folder
ANY = "race, track or quadrotor"
OWN = frozenset({"name", "provenance"})  # keys that a file does not inherit from its base
LISTS = ("gates", "poles", "spheres", "boxes")  # of tables, in a track


@dataclass(frozen=True)
class _Place:
    """Where a table is written.

    Attributes:
        label: what messages call the file.
        folder: where its relative paths start, None for built-in files.
        chain: the files that are being read, outermost first.
    """

    label: str = ""
    folder: Path | None = None
    chain: tuple[str, ...] = ()


@cache
def names(kind: Kind) -> tuple[str, ...]:
    """Names of the built-in descriptions of a kind, sorted."""
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in _data(kind).iterdir() if entry.name.endswith(".toml")))


def load_track(name_or_path: str | Path) -> Track:
    """A built-in track by name, or one from a TOML file.

    Raises:
        InputError: with the file, the key and the reason.
    """
    return _load(Kind.TRACK, str(name_or_path), _Place(), "")


def load_quadrotor(name_or_path: str | Path) -> Quadrotor:
    """A built-in quadrotor by name, or one from a TOML file.

    Raises:
        InputError: with the file, the key and the reason.
    """
    return _load(Kind.QUADROTOR, str(name_or_path), _Place(), "")


def load_race(name_or_path: str | Path) -> Race:
    """A built-in race by name, or one from a TOML file.

    Raises:
        InputError: with the file, the key and the reason.
    """
    return _load(Kind.RACE, str(name_or_path), _Place(), "")


def load(name_or_path: str | Path) -> Description:
    """A description of any kind: the keys of a file decide the kind; a name is looked up among races, tracks, quadrotors.

    Raises:
        InputError: with the file, the key and the reason.
    """
    text = str(name_or_path)
    for kind in Kind:
        if text in names(kind):
            return _load(kind, text, _Place(), "")
    table, inner = _open(ANY, text, _everything(), _Place(), "")
    return _load(_kind_of(table, inner), text, _Place(), "")


def save(path: str | Path, description: Description) -> None:
    """Write a description with everything that it refers to; reading it gives an equal one.

    Raises:
        InputError: when the file cannot be written.
    """
    replace(path, to_toml(description))


def to_toml(description: Description) -> str:
    """A description with everything that it refers to, as TOML; reading it gives an equal one."""
    table = description.model_dump(mode="json", exclude_none=True)
    if isinstance(description, Track):
        table |= _short_lists(description)
    elif isinstance(description, Race):
        table["track"] |= _short_lists(description.track)
    return toml_writer.write(table, inline_lists=True)


def _short_lists(track: Track) -> dict[str, Any]:
    """Gates and obstacles of a track as a person writes them: only keys that differ from their defaults, a bare point as a list."""
    lists = {name: [item.model_dump(mode="json", exclude_defaults=True) for item in getattr(track, name)] for name in LISTS}
    lists["gates"] = [gate["position"] if list(gate) == ["position"] else gate for gate in lists["gates"]]
    return lists


def load_parameters(path: str | Path) -> SavedParameters:
    """Tuned parameters from a file, or from the `parameters.toml` of a study's folder.

    Raises:
        InputError: with the file, the key and the reason.
    """
    path = Path(path)
    path = path / PARAMETERS_FILE if is_there(path) and path.is_dir() else path
    table = read(path, str(path))
    refuse_description(table, str(path))
    return SavedParameters.from_table(table, str(path))


def save_parameters(path: str | Path, parameters: SavedParameters) -> None:
    """Write tuned parameters; reading them gives the same values bit for bit.

    Raises:
        InputError: when the file cannot be written.
    """
    replace(path, write_parameters(parameters))


def write_parameters(parameters: SavedParameters) -> str:
    """The text of the file."""
    head = f"# Tuned by hotlap for {parameters.race}; flown by: hotlap fly RACE --parameters THIS_FILE\n"
    return head + toml_writer.write(parameters.to_table())


def _everything() -> set[str]:
    """Names of the built-in descriptions of all kinds."""
    return {name for kind in Kind for name in names(kind)}


def _data(kind: Kind) -> Traversable:
    return package_files("hotlap") / "data" / f"{Kind(kind)}s"


def _load(kind: Kind, reference: str, place: _Place, key: str) -> Any:
    """Read, complete and check the description that a name or path refers to."""
    table, inner = _open(kind, reference, names(kind), place, key)
    refuse_other_kind(kind, table, inner.label)
    base = table.pop("base", None)
    parent = None if base is None else _refer(kind, base, inner, "base")
    table.setdefault("name", Path(reference).stem if inner.folder else reference)
    return _build(kind, table, parent, inner, "")


def _open(kind: str, reference: str, known: Any, place: _Place, key: str) -> tuple[dict[str, Any], _Place]:
    """The table that a name or path refers to, and where it stands."""
    if kind in TYPES and reference in known:
        label = f"built-in {kind} {reference}"
        path, inner = _data(Kind(kind)) / f"{reference}.toml", _Place(label, None, (*place.chain, label))
    else:
        path = _find(kind, reference, known, place, key)
        label = str(path)
        inner = _Place(label, path.parent, (*place.chain, str(path.absolute().resolve())))
    if inner.chain[-1] in place.chain:
        raise InputError(place.label, key, f"{reference} refers back to itself: {' -> '.join(Path(name).name for name in inner.chain)}")
    return read(path, label), inner


def _find(kind: str, reference: str, known: Any, place: _Place, key: str) -> Path:
    """The file that a path refers to: from the folder of the file that says so, else from the working folder."""
    try:
        candidates = [Path(reference).expanduser()]
        if place.folder is not None and not candidates[0].is_absolute():
            candidates = list(dict.fromkeys([place.folder / candidates[0], candidates[0]]))
        found = next((path for path in candidates if path.exists()), None)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(place.label, key, f"{show(reference)} is no usable path: {cause_of(error)}") from None
    odd = _oddity(found) if found is not None and place.label else ""
    if odd:
        raise InputError(place.label, key, f"{show(reference)} {odd}")
    looks_like_path = "/" in reference or "\\" in reference or reference.lower().endswith((".toml", *ELSEWHERE))
    has_ending = any(is_there(path.with_name(path.name + ".toml")) for path in candidates if path.name)
    if found is not None and (looks_like_path or found.is_file() or not has_ending):
        return found
    if not looks_like_path:
        if has_ending:
            raise InputError(place.label, key, f"there is no {kind} named '{reference}'; the file is {reference}.toml")
        raise UnknownNameError(kind, reference, known, place.label, key)
    hint = _meant(candidates[0], known)
    if place.label:
        raise InputError(place.label, key, f"there is no file {' or '.join(str(path) for path in candidates)}{hint}")
    raise InputError(reference, "", f"there is no such file{hint}")


def _oddity(path: Path) -> str:
    """What stands in the place of a file that another one names; "" where it is one, or cannot be told."""
    with suppress(OSError, ValueError):
        return oddity(path)
    return ""


def _meant(path: Path, known: Any) -> str:
    """What was probably meant by the path of a file that is not there; "" where nothing is near."""
    if path.stem in known and path.parent == Path():
        return f" ({path.stem} is built in: leave the ending away)"
    with suppress(OSError):
        near = get_close_matches(path.stem, [one.stem for one in path.parent.iterdir() if one.suffix == path.suffix], n=1)
        return f" (did you mean {path.with_name(near[0] + path.suffix)}?)" if near else ""
    return ""


def _refer(kind: Kind, value: Any, place: _Place, key: str, inherited: Described | None = None) -> Described:
    """A description written as a name, a path or a table; a table builds on its `base`, or on what is inherited."""
    if isinstance(value, str):
        return _load(kind, value, place, key)
    if not isinstance(value, dict) or key == "base":
        wanted = "a name or a path" if key.endswith("base") else "a name, a path or a table"
        raise InputError(place.label, key, f"must be {wanted}, not {show(value)}")
    table = dict(value)
    parent = inherited
    if "base" in table:
        base = table.pop("base")
        if not isinstance(base, str):
            raise InputError(place.label, f"{key}.base", f"must be a name or a path, not {show(base)}")
        parent = _load(kind, base, place, f"{key}.base")
    if parent is None:
        table.setdefault("name", key)
    return _build(kind, table, parent, place, key)


def _build(kind: Kind, table: dict[str, Any], parent: Described | None, place: _Place, key: str) -> Any:
    """Check a table, completed by what it builds on."""
    table = _with_present_names(TYPES[kind], table, place.label, key)
    if kind is Kind.RACE:
        table = _with_references(table, parent, place)
    whole = _overlay(parent, table, OWN if not key else frozenset())
    return check(TYPES[kind], whole, place.label, key)


def _with_present_names(description: type[Described], table: dict[str, Any], label: str, key: str) -> dict[str, Any]:
    """A table with the present names of its keys; former names are replaced with a note to the user."""
    present = {}
    for name, value in table.items():
        new, dotted = description.renamed.get(name, name), f"{key}.{name}" if key else name
        if new != name and new in table:
            raise InputError(label, dotted, f"is now called {new}, which is there too: leave one of them out")
        if new != name:
            say_renamed(dotted, new, label)
        inner = table_of(description, new)
        present[new] = _with_present_names(inner, value, label, dotted) if inner is not None and isinstance(value, dict) else value
    return present


def _with_references(table: dict[str, Any], parent: Any, place: _Place) -> dict[str, Any]:
    """A race's table with its track and quadrotors in place of their names."""
    table = dict(table)
    for name, kind in (("track", Kind.TRACK), ("vehicle", Kind.QUADROTOR), ("model", Kind.QUADROTOR)):
        if name in table:
            table[name] = _refer(kind, table[name], place, name, getattr(parent, name, None))
    planning = table.get("planning")
    if isinstance(planning, dict) and "quadrotor" in planning:
        inherited = parent.planning.quadrotor if parent is not None else None
        quadrotor = _refer(Kind.QUADROTOR, planning["quadrotor"], place, "planning.quadrotor", inherited)
        table["planning"] = {**planning, "quadrotor": quadrotor}
    return table


def _overlay(parent: Described | None, table: dict[str, Any], dropped: frozenset[str] = frozenset()) -> dict[str, Any]:
    """A description with changes: tables are merged key by key, all other values are replaced."""
    if parent is None:
        return table
    merged = {name: getattr(parent, name) for name in parent.model_fields_set - dropped}
    for key, value in table.items():
        inherited = getattr(parent, key, None)
        overlaid = isinstance(value, dict) and isinstance(inherited, Described)
        merged[key] = _overlay(inherited, value) if overlaid else value
    return merged


def _kind_of(table: dict[str, Any], place: _Place) -> Kind:
    """What a table describes, by the keys that only one kind has, or else by what it builds on."""
    refuse_parameters(table, place.label)
    told = kind_by_keys(table)
    if told is not None:
        return told
    base = table.get("base")
    if isinstance(base, str):
        known = [kind for kind in Kind if base in names(kind)]
        return known[0] if known else _kind_of(*_open(ANY, base, _everything(), place, "base"))
    raise InputError(place.label, "", f"is neither a race (it has a track), a track (gates) nor a quadrotor (mass){strangers(table)}")
