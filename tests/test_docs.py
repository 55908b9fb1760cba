"""What is written about hotlap is true of it."""

import importlib.util
import re
from pathlib import Path

import pytest

from hotlap.feasibility import Level, describe
from hotlap.files.descriptions import load

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


@pytest.mark.parametrize(
    "page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", *sorted(f"docs/{page.name}" for page in ROOT.glob("docs/*.md"))]
)
def test_links_to_files_lead_somewhere(page):
    text = (ROOT / page).read_text()
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((ROOT / page).parent / target).exists(), target
