import re

import pytest

from hotlap.files.descriptions import TYPES, Kind, load
from hotlap.files.documented_keys import documented_keys
from hotlap.files.templates import new
from hotlap.planning.feasibility import Level, describe
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
    assert len(re.findall(r"^# ", text, re.MULTILINE)) <= 3


@KINDS
def test_commented_values_are_the_defaults(kind, tmp_path):
    plain, full = tmp_path / "plain.toml", tmp_path / "full.toml"
    create(plain, new(kind, "mine"))
    create(full, re.sub(r"^# (?=[a-z_]+ = )", "", new(kind, "mine"), flags=re.MULTILINE) if kind is Kind.QUADROTOR else new(kind, "mine"))
    assert load(plain).fingerprint == load(full).fingerprint


@KINDS
def test_a_new_file_has_every_key(kind):
    text = new(kind, "mine")
    for key in documented_keys(TYPES[kind]):
        for inner in documented_keys(key.table) if key.table and f"[{key.name}]" in text else [key]:
            assert re.search(rf"^(# )?(\[.*)?{inner.name}\b", text, re.MULTILINE), inner.name
