"""Every run of a comparison is the run that it would be alone; what is kept is whole; rows say what the runs say."""

from __future__ import annotations

import gzip
import json
import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap import tuners, worlds
from hotlap.analysis import resumable
from hotlap.analysis.comparison import Cell, Run, RunJournal, budget_of, fly_cells, missing
from hotlap.analysis.comparison_table import (
    ALL,
    cells_of,
    comparable_laps,
    completion_band,
    held_cells_of,
    markdown,
    overall,
    profiles,
    rows_of,
    summarise,
)
from hotlap.analysis.resumable import ResumableJobs
from hotlap.core.errors import StudyError
from hotlap.planning import preparation
from hotlap.reference.segmentation import SegmentationRule, segment
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune
from hotlap.tuning.objective import Objective

SETTINGS = TuningSettings(goal=parse_goal("completion=1"), budget=60, reliability=0.0, validation=50)
RESULTS = Path(__file__).parents[2] / "benchmarks" / "results"
NAMES = ("random_search:paper", "metropolis_hastings:tied", "guided_walk:default", "cma_es:log")


@pytest.fixture(autouse=True)
def straight(monkeypatch) -> None:
    """A world, a planner and segments that take no time."""
    monkeypatch.setattr(worlds, "build", lambda *_: FakeWorld())
    monkeypatch.setattr(preparation, "plan", lambda *_, **__: make_scenario().reference)
    monkeypatch.setattr(
        preparation,
        "segment",
        lambda reference, rule: make_scenario().segments if rule is SegmentationRule.PAPER else segment(reference, rule),
    )


def cell(tuner: str = NAMES[1], seeds: tuple[int, ...] = (0, 1, 2, 3), **changes) -> Cell:
    return Cell(make_scenario().race, tuner, TuningSettings(**{**vars(SETTINGS), **changes}), seeds)


def make_run(tuner: str = "a", race: str = "r", seed: int = 0, **changes) -> Run:
    values = {"budget": 200, "flights": 30, "search_flights": 10, "confirmed": True, "completion": 1.0, "cost": 5.0, "lap_time": 5.0}
    plain = {"successes": 45, "validation": 50, "tuner_time": 0.3, "curve": ((1, 0.2), (10, 0.6), (30, 1.0))}
    return Run(**{"race": race, "tuner": tuner, "seed": seed, **values, **plain, **changes})


@pytest.mark.parametrize("tuner", NAMES)
def test_a_run_among_others_is_the_run_alone(tuner):
    others = (cell("random_search:uniform", (0, 5)), cell("trust_region:tied", (1,), budget=30))
    flown = list(fly_cells((cell(tuner), *others)))
    assert [(run.tuner, run.budget) for asked, run in flown] == [(asked.tuner, asked.settings.budget) for asked, run in flown]
    together = {run.seed: run for asked, run in flown if asked.tuner == tuner}
    assert sorted(together) == [0, 1, 2, 3]
    for seed in (1, 3):
        built = tuners.build(tuner)
        scenario = scenario_for(make_scenario(), built)
        tuning = Tuning(built, scenario, TuningSettings(**{**vars(SETTINGS), "seed": seed}))
        last = list(tune(Objective(scenario, FakeWorld()), tuning))[-1]
        run = together[seed]
        assert (run.flights, run.search_flights, run.confirmed) == (last.flights, last.search_flights, last.best.confirmed)
        assert (run.completion, run.cost) == (last.best.completion, last.best.cost)
        assert last.validation is not None
        assert (run.successes, run.validation) == (last.validation.successes, 50)


def test_the_curve_ends_where_the_run_does_and_the_tuner_is_on_the_clock():
    for _, run in fly_cells((cell(),)):
        assert run.curve[-1][1] == run.completion == run.completion_at(run.flights) == run.completion_at(10**6)
        assert list(run.curve) == sorted(run.curve)
        assert run.completion_at(0) == 0.0
        assert run.flights <= run.budget == 60
        assert 0 < run.tuner_time < 5


def test_a_key_changes_with_all_that_decides_about_a_run_but_its_seed():
    same = {cell().key, cell(seeds=(7,)).key}
    others = [cell("cma_es:log"), cell(budget=61), cell(confirm=5), cell(validation=10), cell(goal=parse_goal("mean_error<0.3"))]
    others += [replace(cell(), segments=rule) for rule in (SegmentationRule.NONE, SegmentationRule.EQUAL_TIME)]
    assert len(same) == 1
    assert len({*same, *(other.key for other in others)}) == 8


def test_what_is_done_is_not_flown_again_and_what_may_share_flights_does():
    short, long, dense = cell(seeds=(0, 1, 2)), cell("cma_es:log", seeds=(0, 1, 2, 3), budget=100), cell("guided_walk:default")
    done = {(short.key, 1): make_run(), (long.key, 0): make_run()}
    groups = missing([short, dense, long], done, 1)
    assert [[(part.tuner, part.seeds) for part in group] for group in groups] == [
        [(NAMES[1], (0, 2)), ("cma_es:log", (1, 2, 3))],
        [("guided_walk:default", (0, 1, 2, 3))],
    ]
    assert missing([short], {(short.key, seed): make_run() for seed in range(3)}, 2) == []


def test_runs_by_other_code_are_flown_again_and_can_still_be_read(tmp_path, monkeypatch):
    notes: list[str] = []
    asked = [cell(seeds=(0, 1)), cell("random_search:paper", seeds=(0, 1))]
    first = ResumableJobs(tmp_path, 1, note=notes.append).compare(asked)
    assert ResumableJobs(tmp_path, 1, note=notes.append).compare(asked[::-1]) == [*first[2:], *first[:2]]
    assert notes == [f"{tmp_path / 'runs.jsonl'}: 4 of 4 runs are there already"]
    monkeypatch.setattr(resumable, "digest_code", lambda _: "another")
    kept = (tmp_path / "runs.jsonl").read_bytes()
    again = ResumableJobs(tmp_path, 1, note=notes.append).compare(asked[:1])
    assert [replace(run, tuner_time=0.0) for run in again] == [replace(run, tuner_time=0.0) for run in first[:2]]
    assert notes[1:] == [f"{tmp_path / 'runs.jsonl'}: results of other source code than this are not used; they are computed again"]
    assert (tmp_path / "runs.jsonl").read_bytes().startswith(kept)
    read = sorted(RunJournal(tmp_path).done.values(), key=lambda run: (run.tuner, run.seed))
    assert read == [*again, *first[2:]], "who only reads gets the last of each"


def test_committed_results_can_be_read(tmp_path):
    """They were written before a line said which code had made it."""
    (tmp_path / "runs.jsonl").write_bytes(gzip.decompress((RESULTS / "spiral-53-60-seeds.jsonl.gz").read_bytes()))
    journal = RunJournal(tmp_path)
    assert len(journal.done) >= 60
    assert {run.race for run in journal.done.values()} == {"airsim-spiral-53"}
    assert not RunJournal(tmp_path, "today's").done


def test_cells_that_are_cut_by_different_rules_are_flown_apart():
    whole, paper = replace(cell(seeds=(0,)), segments=SegmentationRule.NONE), cell(seeds=(0,))
    assert sorted(len(group) for group in missing([whole, paper], {}, 1)) == [1, 1]
    assert [run.seed for _, run in fly_cells((whole,))] == [0]


@pytest.mark.parametrize("processes", [1, 2, 3, 50])
def test_there_is_work_for_every_process(processes):
    groups = missing([cell(), cell("cma_es:log")], {}, processes)
    assert len(groups) == min(processes, 4)
    assert sorted((part.tuner, seed) for group in groups for part in group for seed in part.seeds) == sorted(
        (name, seed) for name in (NAMES[1], "cma_es:log") for seed in range(4)
    )


def test_budgets_are_those_of_the_nearest_name():
    budgets = {"": 200, "cma_es": 1000, "cma_es:tied": 500}
    assert [budget_of(name, budgets) for name in ("cma_es:log", "cma_es:tied", "guided_walk:default")] == [1000, 500, 200]


def test_a_run_survives_json_though_it_never_finished_a_lap():
    run = make_run(cost=math.inf, lap_time=math.nan)
    again = Run.load(json.loads(json.dumps(run.dump(), allow_nan=False)))
    assert again.cost == math.inf
    assert math.isnan(again.lap_time)
    assert again.dump() == run.dump()
    assert again.curve == run.curve


def test_the_file_keeps_runs_and_drops_the_line_that_was_being_written(tmp_path):
    with RunJournal.opened(tmp_path) as file:
        for seed in range(3):
            file.add(("key", seed), make_run(seed=seed))
    path = tmp_path / "runs.jsonl"
    path.write_bytes(path.read_bytes()[:-20])
    with RunJournal.opened(tmp_path) as file:
        assert sorted(file.done) == [("key", 0), ("key", 1)]
        file.add(("key", 2), make_run(seed=2, flights=31))
    assert RunJournal(tmp_path).done["key", 2].flights == 31
    assert len(RunJournal(tmp_path).done) == 3


@pytest.mark.parametrize(
    "line",
    [b'{"key": "a"}', b"[1, 2]", b"\xff\xfe", b"", b'{"key": "a", "run": {"cost": 1}}', b"[" * 100_000, b'{"key": 1, "checksum": 1}'],
)
def test_a_damaged_line_is_named_and_left_out_and_those_that_are_whole_stay(tmp_path, line):
    path = tmp_path / "runs.jsonl"
    with RunJournal.opened(tmp_path) as file:
        file.add(("key", 0), make_run(seed=0))
    kept = path.read_bytes()
    path.write_bytes(line + b"\n" + kept)
    with pytest.warns(UserWarning, match=r"runs.jsonl: line 1 is damaged and left out; all others count"):
        assert list(RunJournal(tmp_path).done) == [("key", 0)]
    with pytest.warns(UserWarning, match=r"line 1 is damaged"), RunJournal.opened(tmp_path) as file:
        file.add(("key", 1), make_run(seed=1))
    assert sorted(RunJournal(tmp_path).done) == [("key", 0), ("key", 1)]
    assert path.read_bytes().startswith(kept)
    assert (tmp_path / "runs.jsonl.damaged").read_bytes() == line + b"\n"


def test_a_number_that_has_changed_since_is_found(tmp_path):
    with RunJournal.opened(tmp_path) as file:
        file.add(("key", 0), make_run(seed=0, flights=31))
    path = tmp_path / "runs.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"flights": 31', b'"flights": 13'))
    with pytest.warns(UserWarning, match=r"line 1 is damaged"):
        assert not RunJournal(tmp_path).done


def test_what_is_no_file_is_refused(tmp_path):
    (tmp_path / "runs.jsonl").mkdir()
    with pytest.raises(StudyError, match=r"runs.jsonl: is a folder, not a file"):
        RunJournal(tmp_path)
    (tmp_path / "runs.jsonl").rmdir()
    os.mkfifo(tmp_path / "runs.jsonl")
    with pytest.raises(StudyError, match=r"runs.jsonl: is a pipe, not a file"):
        RunJournal(tmp_path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no full disk at hand")
def test_a_full_disk_is_said_and_loses_nothing(tmp_path):
    with RunJournal.opened(tmp_path) as file:
        file.add(("key", 0), make_run())
        kept = file.path
        file.path = Path("/dev/full")
        with pytest.raises(StudyError, match="what was kept before stays"):
            file.add(("key", 1), make_run(seed=1))
    assert list(RunJournal(kept.parent).done) == [("key", 0)]


def test_a_folder_has_one_writer(tmp_path):
    with RunJournal.opened(tmp_path), pytest.raises(StudyError, match="is working on this"), RunJournal.opened(tmp_path):
        pass


def test_a_row_counts_a_failure_as_infinitely_long():
    runs = [make_run(seed=k, search_flights=k + 1, flights=2 * k + 2) for k in range(3)]
    runs += [make_run(seed=k, confirmed=False, flights=200, search_flights=150, successes=0, lap_time=math.nan) for k in (3, 4)]
    row = summarise("r", "a", runs)
    assert (row.runs, row.success_rate, row.flights_median, row.all_flights_median) == (5, 0.6, 3.0, 6.0)
    assert row.flights_quartiles == (2.0, 3.0, math.inf)
    assert row.validated_rate == pytest.approx(0.6 * 0.9)
    assert row.success_interval[0] < 0.6 < row.success_interval[1]
    assert row.validated_interval[0] <= row.validated_rate <= row.validated_interval[1]
    assert row.completions == ((50, 1.0), (200, 1.0))
    assert row.lap_time_median == 5.0
    assert row.tuner_time == pytest.approx(1.5 / 412)


def test_lap_times_are_compared_where_all_tuners_solved_the_race():
    """The careful tuner alone solves the long race, by a slow lap: that must not make it the slower one."""
    runs = [make_run(name, "short", seed, lap_time=5.0) for name in ("careful", "other") for seed in range(3)]
    runs += [make_run("careful", "long", seed, lap_time=30.0) for seed in range(5)]
    runs += [make_run("other", "long", seed, confirmed=False, lap_time=29.0) for seed in range(4)]
    runs += [make_run("other", "long", 4, lap_time=28.0)]
    rows = {(row.race, row.tuner): (row.lap_time_median, row.lap_times) for row in (*rows_of(runs), *overall(runs))}
    assert comparable_laps(runs) == {("short", 0), ("short", 1), ("short", 2), ("long", 4)}
    assert (rows["long", "careful"], rows["long", "other"]) == ((30.0, 1), (28.0, 1))
    assert (rows[ALL, "careful"], rows[ALL, "other"]) == ((5.0, 4), (5.0, 4))
    never = [*runs, *(make_run("never", "short", seed, confirmed=False) for seed in range(3))]
    assert {row.lap_times for row in overall(never)} == {0}
    assert [cells[-2] for cells in cells_of(overall(never))] == ["lap s (runs)", "-", "-", "-"]


def test_rows_are_of_each_race_and_over_all_the_best_first():
    runs = [make_run("slow", race, seed, search_flights=50) for race in "rs" for seed in range(3)]
    runs += [make_run("fast", race, seed, search_flights=5) for race in "rs" for seed in range(3)]
    runs += [make_run("never", race, seed, confirmed=False) for race in "rs" for seed in range(3)]
    assert [(row.race, row.tuner) for row in rows_of(runs)][:2] == [("r", "slow"), ("s", "slow")]
    assert [(row.race, row.tuner, row.runs) for row in overall(runs)] == [(ALL, "fast", 6), (ALL, "slow", 6), (ALL, "never", 6)]
    shares = profiles(runs, np.array([1.0, 9.0, 10.0, 100.0]))
    assert shares["fast"].tolist() == [1, 1, 1, 1]
    assert shares["slow"].tolist() == [0, 0, 1, 1]
    assert shares["never"].tolist() == [0, 0, 0, 0]


def test_a_profile_leaves_out_what_not_all_have_flown():
    runs = [make_run("a", "r"), make_run("b", "r", search_flights=20), make_run("a", "s", search_flights=1)]
    assert profiles(runs, np.array([1.0, 2.0]))["b"].tolist() == [0, 1]
    assert profiles(runs[2:] + [make_run("b", "t")], np.array([1.0]))["a"].tolist() == [0]


def test_a_band_holds_the_median_between_quartiles():
    runs = [make_run(seed=k, curve=((1, 0.0), (2 + k, 1.0))) for k in range(5)]
    low, middle, high = completion_band(runs, np.array([1, 2, 4, 6]))
    assert middle.tolist() == [0, 0, 1, 1]
    assert (low <= middle).all()
    assert (middle <= high).all()
    assert high.tolist() == [0, 0, 1, 1]


def test_tables_have_a_cell_for_every_column():
    rows = rows_of([make_run(), make_run(seed=1, confirmed=False, lap_time=math.nan)])
    header, *body = cells_of(rows)
    assert all(len(cells) == len(header) for cells in body)
    assert markdown(cells_of(rows)).splitlines()[1].count("---") == len(header)
    assert "50 [9, 91]" in markdown(cells_of(rows)), "one of two, with Wilson's interval"


@pytest.mark.parametrize(
    ("budgets", "head"), [((40, 40), []), ((60, 40), ["completion % at 50"]), ((200, 1000), ["completion % at 50 / 200 / 1000"])]
)
def test_completion_is_said_at_flights_that_some_tuner_was_given(budgets, head):
    cells = cells_of(rows_of([make_run("a", budget=budgets[0]), make_run("b", budget=budgets[1])]))
    assert [name for name in cells[0] if name.startswith("completion")] == head
    assert {len(row) for row in cells} == {9 + len(head)}


def test_what_runs_hold_under_has_a_table_with_a_column_for_each_condition():
    held = [(("as tuned", 50, 50), ("10 % heavier", 50 * k, 50)) for k in range(2)]
    rows = rows_of([make_run(seed=k, held=held[k]) for k in range(2)] + [make_run("b")])
    header, asked, other = held_cells_of(rows)
    assert header == ["race", "tuner", "as tuned %", "10 % heavier %"]
    assert asked[2] == "100 [100, 100]"
    assert asked[3].startswith("50 [")
    assert other[2:] == ["-", "-"]
    assert held_cells_of(rows_of([make_run()])) == [], "nobody asked"
    assert rows[0].dump()["held"][1]["rate"] == 0.5


def test_a_run_with_what_it_holds_under_is_read_back_equal():
    run = make_run(held=(("as tuned", 49, 50), ("10 % heavier", 3, 50)))
    assert Run.load(json.loads(json.dumps(run.dump()))) == run
