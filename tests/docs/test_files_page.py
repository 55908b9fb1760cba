"""The gates and tracks that files.md shows are read as they stand."""

import re
from pathlib import Path

import pytest

from hotlap.files.descriptions import load_track

PAGE = (Path(__file__).parents[2] / "docs" / "files.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^    (\{ position.*?|\[[\d., ]+\])\s+#", PAGE, re.MULTILINE)


def test_there_are_examples_of_gates():
    assert len(EXAMPLES) >= 10


@pytest.mark.parametrize("gate", EXAMPLES)
def test_a_gate_that_is_shown_can_be_read(gate, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f"start = [0, 0, 0]\ngates = [{gate}, [9, 9, 9]]\n")
    assert load_track(path).route


def test_a_track_that_is_shown_can_be_read(tmp_path):
    blocks = [
        re.search(rf"^### {title}\n\n((?:    .*\n)+)", PAGE, re.MULTILINE) for title in ("Laps, start and end", "Floor, box and obstacles")
    ]
    text = "\n".join(block[1] for block in blocks if block).replace("\n    ", "\n").strip()
    path = tmp_path / "mine.toml"
    path.write_text(f"start = [0, 0, 0]\ngates = [[1, 0, 1], [1, 1, 1]]\n{text}\n")
    track = load_track(path)
    assert track.laps == 3
    assert track.poles
    assert track.box
