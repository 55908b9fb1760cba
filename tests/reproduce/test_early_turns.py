"""What the page says of the default weights and dead time is what the world that it names does."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.analysis.transfer import DEFAULT
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.report.article import Article
from hotlap.reproduce.early_turns import SHORT, sets_of, tell_early_turns
from hotlap.reproduce.real_world import AsFlown, _races
from hotlap.tuning.objective import Objective


@pytest.mark.check  # a kernel of its own is compiled, half a minute
def test_dead_time_helps_a_long_horizon_and_harms_a_short_one():
    errors, seeds = {}, flight_seeds(0, Stream.DEMONSTRATION, 0, 2)
    for name, race in _races(quick=False).items():
        scenario = prepare(race)
        for label, parameters in sets_of(scenario, first_guess(scenario, DEFAULT)).items():
            scores = Objective(scenario, AsFlown()).fly(np.repeat(parameters[None], len(seeds), axis=0), seeds)
            errors[name, label] = float(scores.mean_error.mean())
    assert errors["split-s-late", DEFAULT] < 0.95 * errors["split-s", DEFAULT]
    assert errors["split-s-late", SHORT] > 1.05 * errors["split-s", SHORT]
    assert errors["split-s", SHORT] < errors["split-s", DEFAULT]


def test_the_words_have_the_figures_of_the_controller():
    scenario = prepare(_races(quick=True)["split-s"])
    page = Article("page")
    tell_early_turns(page, scenario, first_guess(scenario, DEFAULT), {})
    text = page.markdown
    assert "20 nodes over 2 s are 100 ms apart" in text
    assert "With 0.5 s the nodes are 25 ms apart" in text
