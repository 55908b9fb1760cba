"""An exported study is one that Optuna reads: every search flight a trial."""

from __future__ import annotations

import sys

import numpy as np
import optuna
import pytest

from exporters.studies import tune
from flight.scenarios import make_scenario
from hotlap.core.errors import InputError
from hotlap.core.seeds import Stream
from hotlap.exporters import export
from hotlap.exporters.optuna_study import parameter_name


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """The ledger of a study, its result, and what Optuna reads of it."""
    folder = tmp_path_factory.mktemp("study")
    with tune(folder) as opened:
        (path,) = export(opened, "optuna")
        ledger, result = opened.flights(), opened.result
    storage = optuna.storages.RDBStorage(f"sqlite:///{path}")
    (summary,) = optuna.get_all_study_summaries(storage)
    yield ledger, result, optuna.load_study(study_name=summary.study_name, storage=storage)
    storage.remove_session()
    storage.engine.dispose()


def test_trials_are_the_search_flights_in_order(read):
    ledger, _, loaded = read
    flown, space = ledger.of(Stream.SEARCH), make_scenario().space
    assert len(loaded.trials) == len(flown) > 1
    for i, trial in enumerate(loaded.trials):
        values = [[trial.params[parameter_name(name, segment)] for name in space.names] for segment in range(2)]
        np.testing.assert_array_equal(values, flown.parameters[i])
        assert trial.value == flown.cost[i]
        assert trial.user_attrs["completion"] == flown.completion[i]
        assert trial.user_attrs["accepted"] == flown.accepted[i]
        assert trial.user_attrs.get("lap_time") == (flown.lap_time[i] if np.isfinite(flown.lap_time[i]) else None)


def test_the_best_trial_is_the_cheapest_flight(read):
    ledger, _, loaded = read
    assert loaded.direction == optuna.study.StudyDirection.MINIMIZE
    assert loaded.best_value == ledger.of(Stream.SEARCH).cost.min()


def test_bounds_and_logarithms_are_known(read):
    space = make_scenario().space
    distribution = read[2].trials[0].distributions[parameter_name(space.names[1], 0)]
    assert distribution == optuna.distributions.FloatDistribution(space.low[1], space.high[1], log=True)


def test_the_study_says_what_it_is_of_and_how_it_ended(read):
    _, result, loaded = read
    assert loaded.user_attrs["race"] == make_scenario().race.name
    assert loaded.user_attrs["confirmed"] == result.best.confirmed
    assert loaded.user_attrs["flights"] == result.flights


def test_reflights_are_told_at_the_trials_that_they_confirmed(read):
    ledger, _, loaded = read
    told = sum(trial.user_attrs.get("reflights", 0) for trial in loaded.trials)
    assert told == len(ledger.of(Stream.CONFIRMATION)) > 0
    assert loaded.trials[-1].user_attrs["validation_flights"] == 20


@pytest.mark.check
def test_a_second_export_replaces_the_first(tmp_path):
    with tune(tmp_path) as opened:
        assert export(opened, "optuna") == export(opened, "optuna")
    assert not list(tmp_path.glob("*.part"))


def test_without_optuna_one_line_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with tune(tmp_path) as opened, pytest.raises(InputError, match=r"pip install 'hotlap\[optuna\]'"):
        export(opened, "optuna")
