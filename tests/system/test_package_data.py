"""Files besides Python decide about results, too: where one is another, results are of another hotlap."""

from __future__ import annotations

import shutil

import pytest

from hotlap.analysis.resumable import DECIDING, digest_code
from hotlap.study.versions import digest_of_flights
from hotlap.system import package_data
from hotlap.system.cluster_worker import WITH_DATA, fingerprint, installation
from hotlap.system.package_data import PYTHON, ROOT, data_files, digest_data

READ = {"data/quadrotors", "data/races", "data/tracks"}  # what is read of them is part of a race, and of all that is kept of it
DRAWN = {"report", "py.typed"}  # nothing is computed from them
CLOCK, GUESS, TRACK, PAGE = "worlds/betaflight/lockstep.c", "data/first_guess.json", "data/tracks/circle.toml", "report/page/template.html"


def relative(files) -> set[str]:
    return {path.relative_to(package_data.ROOT).as_posix() for path in files}


def is_below(path: str, places: set[str]) -> bool:
    return any(path == place or path.startswith(f"{place}/") for place in places)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The data of a hotlap that can be changed; gives what forgets the digests of before."""
    for name in (CLOCK, GUESS, TRACK, PAGE):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    monkeypatch.setattr(package_data, "ROOT", tmp_path)

    def forget() -> None:
        digest_data.cache_clear()
        installation.cache_clear()

    forget()
    yield forget
    forget()


def everything() -> list[str]:
    return [digest_code("hotlap.analysis.learning"), digest_of_flights(), fingerprint()]


def test_no_file_is_left_out_that_decides():
    files = relative(path for path in ROOT.rglob("*") if path.is_file() and path.suffix not in PYTHON and not path.name.startswith("."))
    assert relative(data_files(*DECIDING)) == {path for path in files if not is_below(path, READ | DRAWN)}
    assert relative(data_files(*WITH_DATA)) == {path for path in files if not is_below(path, DRAWN)}


@pytest.mark.parametrize(
    ("name", "changed"),
    [(CLOCK, [True, True, True]), (GUESS, [True, False, True]), (TRACK, [False, False, True]), (PAGE, [False, False, False])],
)
def test_results_studies_and_workers_know_the_data_that_decide_about_them(installed, tmp_path, name, changed):
    before = everything()
    assert everything() == before
    with (tmp_path / name).open("ab") as file:
        file.write(b" ")
    installed()
    assert [one != other for one, other in zip(before, everything(), strict=True)] == changed


def test_a_file_more_or_of_another_name_is_other_data(installed, tmp_path):
    found = {digest_data("worlds")}
    (tmp_path / "worlds" / "more.c").write_text("x")
    installed()
    found.add(digest_data("worlds"))
    (tmp_path / "worlds" / "more.c").rename(tmp_path / "worlds" / "most.c")
    installed()
    found.add(digest_data("worlds"))
    (tmp_path / "worlds" / "more.py").write_text("x")
    installed()
    assert len(found) == 3
    assert digest_data("worlds") in found
