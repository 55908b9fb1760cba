import re

import pytest

from hotlap.feasibility import Level, describe
from hotlap.files.descriptions import Kind, load, load_track
from hotlap.files.documented_keys import documented_keys
from hotlap.files.recognition import TYPES
from hotlap.files.templates import EXAMPLES, HEADS, new
from hotlap.system.text_files import create

KINDS = pytest.mark.parametrize("kind", list(Kind))


@KINDS
def test_a_new_file_loads_and_checks_clean(kind, tmp_path):
    path = tmp_path / "mine.toml"
    create(path, new(kind, 'my "own" one'))
    description = load(path)
    assert isinstance(description, TYPES[kind])
    assert description.name == 'my "own" one'
    assert [finding for finding in describe(description) if finding.level is Level.WARNING] == []


@KINDS
def test_every_line_of_a_new_file_may_be_uncommented(kind, tmp_path):
    path = tmp_path / "mine.toml"
    text = re.sub(r"^# (?=[a-z_]+ = |\[)", "", new(kind, "mine"), flags=re.MULTILINE)
    create(path, text)
    assert isinstance(load(path), TYPES[kind])
    assert len(re.findall(r"^# ", text, re.MULTILINE)) == HEADS[kind].count("\n") + 2, "what explains the file stays"


@KINDS
def test_commented_values_are_the_defaults(kind, tmp_path):
    plain, full = tmp_path / "plain.toml", tmp_path / "full.toml"
    examples = {name for name in EXAMPLES[kind] if "." not in name}
    defaults = "|".join(key.name for key in documented_keys(TYPES[kind]) if key.name not in examples)
    create(plain, new(kind, "mine"))
    create(full, re.sub(rf"^# (?=({defaults}) = )", "", new(kind, "mine"), flags=re.MULTILINE))
    assert load(plain).fingerprint == load(full).fingerprint


@KINDS
def test_a_new_file_has_every_key(kind):
    text = new(kind, "mine")
    for key in documented_keys(TYPES[kind]):
        for inner in documented_keys(key.table) if key.table and f"[{key.name}]" in text else [key]:
            assert re.search(rf"^(# )?(\[.*)?{inner.name}\b", text, re.MULTILINE), inner.name


def test_a_new_track_shows_openings_with_a_direction_and_a_bare_point(tmp_path):
    path = tmp_path / "mine.toml"
    create(path, new(Kind.TRACK, "mine"))
    gates = load_track(path).gates
    assert [gate.oriented for gate in gates] == [gate.shaped for gate in gates] == [True, True, True, False]
