"""What is written about hotlap is true of it."""

import importlib.util
import re
import shlex
from pathlib import Path

import pytest

from hotlap.cli.arguments import COMMANDS
from hotlap.cli.main import main
from hotlap.feasibility import Level, describe
from hotlap.files.descriptions import load
from hotlap.race.hold import parse_hold

ROOT = Path(__file__).parents[1]


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)


def test_the_tables_of_keys_are_up_to_date():
    specification = importlib.util.spec_from_file_location("tables", ROOT / "docs" / "tables.py")
    assert specification is not None
    assert specification.loader is not None
    tables = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(tables)
    text = tables.PAGE.read_text(encoding="utf-8")
    assert tables.fill(text) == text, "run: python docs/tables.py"


def test_the_files_of_the_readme_load_without_a_warning(tmp_path):
    texts = {text.splitlines()[0].removeprefix("# "): text for text in blocks("README.md", "toml")}
    assert set(texts) == {"my-drone.toml", "my-race.toml", "my-track.toml"}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    for name in texts:
        assert all(finding.level is not Level.WARNING for finding in describe(load(tmp_path / name)))


def own_drone():
    """The part of the README about a drone of one's own, and its commands."""
    text = (ROOT / "README.md").read_text().partition("## Your own drone\n")[2].partition("\n## ")[0]
    return text, [shlex.split(line, comments=True)[1:] for line in text.splitlines() if line.startswith("    hotlap ")]


def test_the_readme_tells_of_conditions_and_of_the_fastest_lap_that_holds():
    text, commands = own_drone()
    tunes = [COMMANDS["tune"].parser("tune").parse(command[1:]) for command in commands if command[0] == "tune"]
    assert "chooses the plan" in text
    assert [bool(options.hold) for options in tunes] == [False, True, True]
    assert all(parse_hold(options.hold) for options in tunes[1:])
    assert [options.goal for options in tunes] == ["completion=1", "completion=1", "lap_time"]
    assert all((ROOT / page).exists() for page in ("docs/conditions.md", "docs/fastest.md"))
    assert "docs/conditions.md" in text
    assert "docs/fastest.md" in text


@pytest.mark.check
def test_the_commands_of_the_readme_about_a_drone_of_ones_own_work_as_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _, commands = own_drone()
    for command in commands:
        if command[0] == "check":
            for text in blocks("README.md", "toml"):
                Path(text.splitlines()[0].removeprefix("# ")).write_text(text)
        if "lap_time" not in command:  # it takes minutes, and has tests of its own
            assert main(command) == 0, command


@pytest.mark.parametrize(
    "page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", *sorted(f"docs/{page.name}" for page in ROOT.glob("docs/*.md"))]
)
def test_links_to_files_lead_somewhere(page):
    text = (ROOT / page).read_text()
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((ROOT / page).parent / target).exists(), target
