"""hotlap's tuners as samplers of Optuna: any objective, resumable, in parallel."""

from __future__ import annotations

import math
import os
import pickle
import threading

import numpy as np
import optuna
import pytest
from optuna.samplers import RandomSampler
from optuna.study import Study
from optuna.trial import TrialState

from hotlap import tuners
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.optuna import HotlapSampler
from hotlap.optuna.run import Note, Origin
from hotlap.optuna.sampler import BLOCK, anywhere
from sampler.recording import Recorder

DEFAULTS = tuple(dict.fromkeys(name.partition(":")[0] for name in tuners.names()))
EVERY = pytest.mark.parametrize("tuner", DEFAULTS)
SOME = pytest.mark.parametrize("tuner", ["guided_walk", "cma_es", "metropolis_hastings"])


@pytest.fixture(autouse=True)
def quiet():
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    yield
    optuna.logging.set_verbosity(before)


def bowl(trial: optuna.Trial) -> float:
    """Numbers of every kind, one of no kind, and noise that depends on the trial alone."""
    x = trial.suggest_float("x", -5.0, 5.0)
    y = trial.suggest_float("y", 1e-3, 1e3, log=True)
    n = trial.suggest_int("n", 1, 64, log=True)
    kind = trial.suggest_categorical("kind", ("good", "bad"))
    noise = 0.1 * np.random.default_rng(trial.number).standard_normal()
    return float((x - 2) ** 2 + (np.log10(y) - 1) ** 2 + np.log2(n / 8) ** 2 + (kind == "bad") + noise)


def new(tuner: str, seed: int | None = 1, direction: str = "minimize", storage=None, **options) -> Study:
    return optuna.create_study(sampler=HotlapSampler(tuner, seed=seed, **options), direction=direction, storage=storage)


def asked(study: Study) -> list[dict]:
    return [trial.params for trial in study.trials]


@EVERY
def test_every_tuner_runs(tuner):
    study = new(tuner)
    study.optimize(bowl, n_trials=30)
    points = {(params["x"], params["y"], params["n"]) for params in asked(study)}
    assert len(points) > (5 if tuner == "safe_bayesian" else 15), "it went on searching; the safe one tries the first guess again"


@EVERY
def test_a_second_process_goes_on_as_the_first_would_have(tuner, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: None)  # no power goes here
    whole = new(tuner, seed=None)
    whole.sampler._seed = 7
    whole.optimize(bowl, n_trials=24)
    storage = optuna.storages.JournalStorage(optuna.storages.journal.JournalFileBackend(str(tmp_path / "journal.log")))
    first = new(tuner, seed=7, storage=storage)
    first.optimize(bowl, n_trials=13)
    storage = optuna.storages.JournalStorage(optuna.storages.journal.JournalFileBackend(str(tmp_path / "journal.log")))
    second = optuna.load_study(study_name=first.study_name, storage=storage, sampler=HotlapSampler(tuner))
    second.optimize(bowl, n_trials=11)
    assert asked(second) == asked(whole)


@pytest.mark.check
@pytest.mark.parametrize("tuner", ["guided_walk", "cma_es", "trust_region"])
def test_better_than_random_on_a_noisy_function(tuner):
    def noisy(trial):
        x = np.array([trial.suggest_float(f"x{k}", -3.0, 3.0) for k in range(4)])
        return float(((x - 0.7) ** 2).sum() + 0.3 * np.random.default_rng(trial.number).standard_normal())

    def distance(sampler):
        study = optuna.create_study(sampler=sampler)
        study.optimize(noisy, n_trials=80)
        return np.linalg.norm([value - 0.7 for value in study.best_params.values()])

    ours = [distance(HotlapSampler(tuner, seed=seed)) for seed in range(5)]
    random = [distance(RandomSampler(seed=seed)) for seed in range(5)]
    assert np.median(ours) < 0.7 * np.median(random)


@SOME
def test_maximising_is_minimising_the_negative(tuner):
    down, up = new(tuner), new(tuner, direction="maximize")
    down.optimize(bowl, n_trials=30)
    up.optimize(lambda trial: -bowl(trial), n_trials=30)
    assert asked(up) == asked(down)


@SOME
@pytest.mark.parametrize("factor", [2.0**-20, 2.0**20])
def test_the_unit_of_the_objective_does_not_matter(tuner, factor):
    plain, scaled = new(tuner), new(tuner)
    plain.optimize(bowl, n_trials=25)
    scaled.optimize(lambda trial: factor * bowl(trial), n_trials=25)
    assert asked(scaled) == asked(plain)


def half_fails(trial: optuna.Trial) -> float:
    """Below zero it is a bowl, above it fails, or is pruned."""
    x, y = trial.suggest_float("x", -1.0, 1.0), trial.suggest_float("y", -1.0, 1.0)
    if x > 0 and trial.number % 2:
        raise optuna.TrialPruned
    if x > 0:
        raise ZeroDivisionError
    return (x + 0.5) ** 2 + y**2


def test_failed_and_pruned_trials_are_told_as_failures():
    Recorder.told.clear()
    study = new("sampler.recording.Recorder:log_uniform", batch=1)
    study.optimize(half_fails, n_trials=60, catch=(ZeroDivisionError,))
    assert {trial.state for trial in study.trials} == {TrialState.COMPLETE, TrialState.FAIL, TrialState.PRUNED}
    run = [trial for trial in study.trials if Note.of(trial) is not None]
    told = Recorder.told[1:]  # the first one is the trial that it began at
    assert len(told) == len(run) - 1 > 40
    for cost, trial in zip(told, run, strict=False):
        assert (cost == np.inf) == (trial.state is not TrialState.COMPLETE)


def test_what_is_told_is_positive_and_grows_with_the_value():
    origin = Origin(0, "", "", 0, 1, 0, best=-3.0, spread=2.0)
    told = [origin.scaled(cost) for cost in (-np.inf, -1e300, -1e3, -5.0, -3.0, -1.0, 1e3, 1e300, np.inf)]
    assert told == sorted(told)
    assert told[0] >= 0
    assert told[4] == 1.0
    assert np.isfinite(told[:-1]).all()


def test_the_guided_walk_keeps_away_from_what_fails():
    study = new("guided_walk")
    study.optimize(half_fails, n_trials=60, catch=(ZeroDivisionError,))
    assert np.mean([trial.state is TrialState.COMPLETE for trial in study.trials[20:]]) > 0.7


@pytest.mark.parametrize("tuner", [tuner for tuner in DEFAULTS if tuner != "safe_bayesian"])
def test_trials_under_way_do_not_ask_for_the_same(tuner):
    study = new(tuner)
    study.optimize(bowl, n_trials=6)
    for _ in range(3):
        waiting = [study.ask() for _ in range(5)]
        values = [bowl(trial) for trial in waiting]
        for trial, value in reversed([*zip(waiting, values, strict=True)]):
            study.tell(trial, value)
    numbers = [(trial.params["x"], trial.params["y"]) for trial in study.trials]
    assert len(set(numbers)) > 15


@SOME
def test_threads_share_a_study(tuner):
    study = new(tuner)
    study.optimize(bowl, n_trials=40, n_jobs=4)
    assert len(study.trials) == 40
    notes = [note.point for note in map(Note.of, study.trials) if note is not None]
    assert len(set(notes)) == len(notes), "no two trials are the same point of a run"


def test_processes_share_a_study_through_its_storage():
    """Two samplers that know nothing of each other: what one has taken, the other does not take."""
    storage = optuna.storages.InMemoryStorage()
    first = new("cma_es", storage=storage, elsewhere=0)
    first.optimize(bowl, n_trials=5)
    second = optuna.load_study(study_name=first.study_name, storage=storage, sampler=HotlapSampler("cma_es", seed=1, elsewhere=0))
    barrier = threading.Barrier(2)

    def work(study):
        barrier.wait()
        study.optimize(bowl, n_trials=20)

    threads = [threading.Thread(target=work, args=(study,)) for study in (first, second)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    notes = [note.point for note in map(Note.of, first.trials) if note is not None]
    assert len(notes) == 40
    assert len(set(notes)) == len(notes)


def test_a_trial_that_was_killed_does_not_stop_the_others():
    study = new("metropolis_hastings")
    study.optimize(bowl, n_trials=8)
    study.ask().suggest_float("x", -5.0, 5.0)  # never told
    study.optimize(bowl, n_trials=10)
    runs = {note.origin.run for note in map(Note.of, study.trials) if note is not None}
    assert runs == {0, 1}


@SOME
def test_it_begins_at_a_trial_of_ones_own(tuner):
    study = new(tuner, startup=1)
    study.enqueue_trial({"x": 2.0, "y": 10.0, "n": 8, "kind": "good"})
    study.optimize(bowl, n_trials=12)
    assert study.trials[0].params["x"] == 2.0
    assert all(abs(trial.params["x"] - 2.0) < 4 for trial in study.trials[1:6])


def test_what_is_enqueued_later_is_tried_as_it_is():
    study = new("cma_es")
    study.optimize(bowl, n_trials=10)
    study.enqueue_trial({"x": 1.25, "y": 10.0})
    study.optimize(bowl, n_trials=8)
    assert (study.trials[10].params["x"], study.trials[10].params["y"]) == (1.25, 10.0)
    assert Note.of(study.trials[10]) is None


def test_a_search_space_that_changes_begins_a_new_run():
    study = new("cma_es")
    study.optimize(lambda trial: trial.suggest_float("x", -5, 5) ** 2, n_trials=10)
    study.optimize(lambda trial: trial.suggest_float("x", -2, 2) ** 2 + trial.suggest_float("z", -1, 1), n_trials=20)
    assert len(study.trials) == 30


def test_objectives_without_numbers_and_without_values_are_drawn_at_random():
    study = new("guided_walk")
    study.optimize(lambda trial: float(trial.suggest_categorical("kind", (1, 2, 3))), n_trials=12)
    assert study.best_value == 1.0


def test_several_objectives_are_refused():
    study = optuna.create_study(directions=["minimize", "minimize"], sampler=HotlapSampler())
    with pytest.raises(ValueError, match="is for one objective; the study has 2"):
        study.optimize(lambda trial: (trial.suggest_float("x", 0, 1), 0.0), n_trials=1)


def test_unknown_tuners_and_senseless_numbers_are_refused():
    with pytest.raises(UnknownNameError, match="did you mean cma_es"):
        HotlapSampler("cma_e")
    with pytest.raises(ValueError, match="at least 1"):
        HotlapSampler(startup=0)


def test_a_sampler_can_be_sent_to_another_process():
    study = new("cma_es")
    study.optimize(bowl, n_trials=12)
    copy = pickle.loads(pickle.dumps(study.sampler))  # noqa: S301  our own
    study.sampler = copy
    study.optimize(bowl, n_trials=4)
    assert len(study.trials) == 16


def test_a_run_of_another_version_is_left_and_a_new_one_begun():
    study, copy = new("metropolis_hastings"), new("metropolis_hastings")
    study.optimize(bowl, n_trials=10)
    for trial in study.trials:
        moved = trial.params if trial.number != 8 else {**trial.params, "x": 0.5 * trial.params["x"]}
        options = {"value": trial.value, "distributions": trial.distributions, "system_attrs": trial.system_attrs}
        copy.add_trial(optuna.create_trial(params=moved, **options))
    study.optimize(bowl, n_trials=1)
    copy.optimize(bowl, n_trials=1)
    assert Note.of(study.trials[10]).origin.run == 0
    assert Note.of(copy.trials[10]).origin.run == 1


@pytest.mark.parametrize(("tuner", "direction"), [("bayesian", "minimize"), ("particle_swarm", "maximize"), ("guided_walk", "maximize")])
def test_a_value_that_nothing_can_beat_does_not_end_the_search(tuner, direction):
    """As of a logarithm of nothing: the others are still told apart."""
    sign = 1.0 if direction == "minimize" else -1.0

    def objective(trial):
        x = trial.suggest_float("x", 0.0, 1.0)
        return sign * (-math.inf if trial.number == 3 else (x - 0.3) ** 2)

    study = optuna.create_study(sampler=HotlapSampler(tuner, seed=1), direction=direction)
    study.optimize(objective, n_trials=40)
    tried = np.array([trial.params["x"] for trial in study.trials[10:]])
    assert np.isfinite(tried).all()
    assert len(np.unique(tried)) > 5
    assert np.abs(tried - 0.3).min() < 0.05


@pytest.mark.check
@EVERY
def test_every_tuner_by_its_default_covers_a_flat_range_in_200_trials(tuner):
    """Of a value that is the same everywhere, in the user's own units; the random trials of the beginning do not count."""
    study = new(tuner)
    study.optimize(lambda trial: 0.0 * (trial.suggest_float("x", -3000.0, 7000.0) + trial.suggest_float("y", 0.001, 0.002)), n_trials=200)
    for name, low, high in (("x", -3000.0, 7000.0), ("y", 0.001, 0.002)):
        tried = [trial.params[name] for trial in study.trials[5:]]
        assert (max(tried) - min(tried)) / (high - low) >= 0.9, name


def test_random_search_is_uniform_over_the_range():
    study = new("random_search", elsewhere=0)
    study.optimize(lambda trial: (trial.suggest_float("x", -3000.0, 7000.0) - 6000.0) ** 2, n_trials=205)
    counts, _ = np.histogram([trial.params["x"] for trial in study.trials[5:]], bins=10, range=(-3000.0, 7000.0))
    assert counts.min() >= 8
    assert counts.max() <= 36


def test_trials_elsewhere_lie_in_every_stratum_of_every_axis():
    for block in range(3):
        points = np.array([anywhere(block * BLOCK + i, 3, seed=4) for i in range(BLOCK)])
        assert (np.sort((points * BLOCK).astype(int), axis=0) == np.arange(BLOCK)[:, None]).all()
    assert not np.array_equal(anywhere(0, 3, seed=4), anywhere(0, 3, seed=5))
    assert not np.array_equal(anywhere(0, 3, seed=4), anywhere(BLOCK, 3, seed=4))


def test_a_tuner_begins_anew_where_a_trial_elsewhere_is_better():
    """A narrow well, and a slope that leads away from it."""

    def well(trial):
        x = trial.suggest_float("x", 0.0, 100.0)
        return -10.0 + abs(x - 80) if abs(x - 80) < 5 else x / 100

    study, without = new("metropolis_hastings"), new("metropolis_hastings", elsewhere=0)
    for each in (study, without):
        each.enqueue_trial({"x": 0.0})
        each.optimize(well, n_trials=250)
    assert {note.origin.run for note in map(Note.of, without.trials) if note is not None} == {0}
    runs = {note.origin.run for note in map(Note.of, study.trials) if note is not None}
    assert len(runs) > 1
    assert study.best_value < -9


def test_a_tuner_of_ones_own_that_breaks_the_protocol_is_one_line(tmp_path, monkeypatch):
    (tmp_path / "silent_tuner.py").write_text(
        "from hotlap.tuners.random_search import PRESETS, RandomSearch\n"
        "class Silent(RandomSearch):\n    def tell(self, parameters, scores):\n        pass\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    study = new("silent_tuner.Silent")
    with pytest.raises(InputError, match=r"^tuner: silent_tuner.Silent:paper: tell must return which candidates it accepts"):
        study.optimize(bowl, n_trials=30)


def test_senseless_shares_of_trials_elsewhere_are_refused():
    with pytest.raises(ValueError, match="elsewhere must be 0, or 2 and more, not 1"):
        HotlapSampler(elsewhere=1)
