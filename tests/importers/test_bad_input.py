"""Whatever stands in a file: a description that can be, or one line that names file and key."""

from __future__ import annotations

import copy
import json
import math
import os
import random
import sys
from pathlib import Path

import pytest

import hotlap.importers
from hotlap.core.errors import InputError
from hotlap.files.descriptions import load
from hotlap.importers import FORMATS, documents, read
from importers.changed import QUADROTORS, SAMPLES, SEVERAL, TRACKS, changed

EACH = [*((sample, None) for sample in (*TRACKS, *QUADROTORS)), (SEVERAL, "small")]
ODD = (None, "x", "a\nb", math.nan, math.inf, True, [], {}, -1, 0, 1e12, [[1, 2], [3]], [0, 0, 0], [math.nan] * 3, {"a": 1})
MOST_PLACES = 25
HARMFUL = {
    "bomb.yaml": ('a: &a ["x", "x"]\nb: [*a, *a]\n', "is not valid YAML: line 2: references (*name) are not read"),
    "objects.yaml": ("mass: !!python/object/apply:os.getcwd []\n", "is not valid YAML: line 1: tags (!name) are not read"),
    "tagged.yaml": ('a: 1\nmass: !!int ""\n', "is not valid YAML: line 2: tags (!name) are not read"),
    "twice.yaml": ("mass: 1\nmass: 2\n", "mass is there twice in one table"),
    "bomb.sdf": ('<!DOCTYPE a [<!ENTITY b "c">]><sdf>&b;</sdf>', "has a document type or entities, which are not read"),
    "outside.urdf": ('<!DOCTYPE robot SYSTEM "file:///etc/hostname"><robot/>', "has a document type or entities"),
    "deep.yaml": ("[" * 20_000, "is nested too deeply"),
    "deep.toml": (f"a = {'[' * 5_000}{']' * 5_000}", "is nested too deeply"),
    "deep.sdf": (f"<sdf>{'<model>' * 3_000}{'</model>' * 3_000}</sdf>", "is nested too deeply"),
    "dotted.toml": (f"kappa = 1\nmass{'.a' * 300} = 1\n", "is nested too deeply"),
    "long.toml": (f"kappa = 1\nmass = 0x{'f' * 5_000}\n", "mass: must be a whole number of at most 64 bits"),
    "hexadecimal.yaml": (f"kappa: 1\nmass: 0x{'f' * 5_000}\n", "mass: must be a whole number of at most 64 bits"),
    "long.yaml": (f"mass: {'1' * 5_000}", "is not valid YAML"),
    "large.yaml": ("#" * (documents.MAX_BYTES + 1), "is larger than 0.5 MB"),
    "broken.toml": ("a = [1\n", "is not valid TOML"),
    "broken.yaml": ("a: [1\n", "is not valid YAML: line 2, column 1"),
    "broken.sdf": ("<sdf><model></sdf>", "is not valid XML"),
    "empty.yaml": ("", "holds no keys"),
    "list.yaml": ("- 1\n", "holds no keys"),
    "numbers.yaml": ("1: {n_motors: 4}\non: {n_motors: 4}\n", "describes 2 vehicles; choose one with name=...: 1, on"),
    "short.yaml": ("kappa: 1\nmass: 1\nt_BM: [[1, 2, 3, 4]]\n", "t_BM: must have 3 rows, not 1"),
    "endless.sdf": (f"<sdf><model><include><uri>{'a' * 300}</uri></include></model></sdf>", "no model has plugins of motors"),
    "unknown.yaml": ("colour: red\n", "is none of what can be read: a track of TOGT-Planner (YAML); "),
    "unknown.xml": ("<html/>", "is none of what can be read"),
    "own.toml": ("start = [0, 0, 1]\ngates = [[1, 0, 1]]\nend = [2, 0, 1]\n", "is a file of hotlap itself: hotlap.check("),
}


@pytest.mark.parametrize("name", HARMFUL)
def test_a_file_that_could_harm_or_is_none_is_refused_in_one_line(tmp_path, name):
    text, said = HARMFUL[name]
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        read(path)
    assert str(error.value).startswith(f"{path}: ")
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_what_is_no_text_and_what_is_not_there_is_said(tmp_path):
    path = tmp_path / "drone.yaml"
    with pytest.raises(InputError, match="there is no such file"):
        read(path)
    with pytest.raises(InputError, match="is a folder, not a file"):
        read(tmp_path)
    path.write_bytes(b"mass: \xff\xfe\n")
    with pytest.raises(InputError, match=r"is not UTF-8 text \(byte 7\)"):
        read(path)


@pytest.mark.parametrize(
    ("sample", "change", "said"),
    [
        ("togt_drone.yaml", ("mass:        0.80\n", ""), "mass: is missing"),
        ("togt_drone.yaml", ("0.80", ".nan"), "mass: must be a finite number, not nan"),
        ("togt_drone.yaml", ("0.80", "light"), 'mass: must be a finite number, not "light"'),
        ("togt_drone.yaml", ("0.80", "-1"), "mass: must be greater than 0, not -1"),
        ("togt_drone.yaml", ("0.80", "800"), "mass: 800 kg is no quadrotor"),
        ("togt_track.yaml", ("width: 2.4\n  height: 2.0\n  marginW", "height: 2.0\n  marginW"), "Gate1.width: is missing"),
        ("togt_track.yaml", ("rpy: [0.0, 0.0, 0.0]", "rpy: [0.0, 0.0]"), "Gate3.rpy: must be a list of 3 numbers, not [0.0, 0.0]"),
        ("togt_track.yaml", ("PentagonPrisma", "StarPrisma"), "Gate3.type: 'StarPrisma' is none of SingleBall"),
        ("togt_track.yaml", ("margin: 0.2\n  length", "margin: 1.2\n  length"), "Gate4: its size, less its margin, is no opening"),
        ("togt_track.yaml", ("'Gate5'", "'Gate7'"), "Gate7: is missing"),
        ("lsy_level.toml", ("pos = [0.0, 0.75, 1.5]", "pos = [0.0, 0.75, -1.5]"), "env.track.obstacles[0].pos: must be the top of a pole"),
        ("rpg_track.yaml", ("[9.0, 6.5, 1.0]", "[9.0, 6.5]"), "gates[1]: must be a list of 3 numbers"),
        (
            "px4.sdf",
            ("<mass>1.4</mass>", "<mass>heavy</mass>"),
            'model[hawk].link[base_link].inertial.mass: must be a finite number, not "heavy"',
        ),
        ("pybullet.urdf", ('kf="4.0e-10" ', ""), "properties.kf: is missing"),
    ],
)
def test_a_key_that_is_missing_or_wrong_is_named(tmp_path, sample, change, said):
    with pytest.raises(InputError) as error:
        read(changed(sample, tmp_path, change))
    assert said in str(error.value)


def places(value, place=()):
    """Every place in nested tables and lists."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in inner:
        yield (*place, key)
        yield from places(item, (*place, key))


@pytest.mark.parametrize(("sample", "name"), [row for row in EACH if not row[0].endswith(("sdf", "urdf"))])
def test_an_odd_value_anywhere_makes_a_description_or_one_line(monkeypatch, sample, name):
    whole = documents.read_document(SAMPLES / sample)
    everywhere = sorted(places(whole), key=str)
    found = random.Random(0).sample(everywhere, min(MOST_PLACES, len(everywhere)))
    for *above, last in found:
        for odd in ODD:
            table = copy.deepcopy(whole)
            holder = table
            for key in above:
                holder = holder[key]  # pyright: ignore[reportArgumentType, reportCallIssue]
            holder[last] = odd  # pyright: ignore[reportArgumentType, reportCallIssue]
            monkeypatch.setattr(hotlap.importers, "read_document", lambda _, table=table: table)
            try:
                text = read(SAMPLES / sample, name).text
            except InputError as error:
                text = str(error)
                assert "\n" not in text, (above, last, odd)
            assert text


@pytest.mark.parametrize(("sample", "tags"), [("px4.sdf", 14), ("pybullet.urdf", 6)])
def test_an_odd_text_in_any_kind_of_element_makes_a_description_or_one_line(monkeypatch, sample, tags):
    whole = documents.read_document(SAMPLES / sample)
    kinds = {element.tag: k for k, element in enumerate(whole.iter()) if k}  # pyright: ignore[reportAttributeAccessIssue]
    assert len(kinds) >= tags
    for k in kinds.values():
        for odd in ("", "x", "nan", "-1", "0", "1 2", "a\nb"):
            root = copy.deepcopy(whole)
            element = list(root.iter())[k]  # pyright: ignore[reportAttributeAccessIssue]
            element.text = odd
            element.attrib |= dict.fromkeys(element.attrib, odd)
            monkeypatch.setattr(hotlap.importers, "read_document", lambda _, root=root: root)
            try:
                text = read(SAMPLES / sample).text
            except InputError as error:
                text = str(error)
                assert "\n" not in text, (element.tag, odd)
            assert text


def test_numbers_that_yaml_takes_for_text_are_numbers(tmp_path):
    assert read(changed("togt_drone.yaml", tmp_path, ("0.80", "8e-1"))).description.mass == 0.8


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are text here")
def test_a_file_whose_name_is_no_text_is_read(tmp_path):
    path = tmp_path / os.fsdecode(b"\xff.urdf")
    path.write_bytes((SAMPLES / "pybullet.urdf").read_bytes())
    assert read(path).text.isascii()


def test_every_format_has_a_sample():
    kinds = [read(SAMPLES / sample, name).format for sample, name in EACH]
    assert set(kinds) == {format_.name for format_ in FORMATS}


@pytest.mark.parametrize(("sample", "name"), EACH)
def test_what_is_written_loads_again_and_says_what_it_was_made_from(tmp_path, sample, name):
    imported = read(SAMPLES / sample, name)
    path = tmp_path / "written.toml"
    path.write_text(imported.text, encoding="utf-8")
    assert load(path) == imported.description
    first, *others = imported.text.splitlines()
    assert first == f"# A {imported.kind} made by hotlap import from {SAMPLES / sample}: {imported.format}." or len(first) > 100
    comments = " ".join(line[1:].strip() for line in others if line.startswith("#"))
    assert all(remark in comments for remark in (*imported.taken, *imported.lost))
    assert all(len(line) <= 140 for line in imported.text.splitlines() if line.startswith("#"))


def test_a_name_that_is_no_name_of_a_line_stays_on_one(tmp_path):
    text = json.dumps(
        {
            "initState": {"pos": [0, 0, 1]},
            "orders": ["a\n[b]"],
            "a\n[b]": {"type": "SingleBall", "position": [3, 0, 1], "radius": 1},
            "c\nd = 1": 2,
        }
    )
    path = tmp_path / "odd.yaml"
    path.write_text(text, encoding="utf-8")
    imported = read(path)
    assert "#   c\\nd = 1: is not among the orders" in imported.text.splitlines()
    assert "d = 1" not in imported.table


def test_the_file_is_told_by_its_content_not_by_its_name(tmp_path):
    path = tmp_path / "anything.dat"
    path.write_text((SAMPLES / "px4.sdf").read_text(encoding="utf-8"), encoding="utf-8")
    assert read(Path(path)).format == "a multirotor for Gazebo (SDF)"
