"""A study says where it has changed nothing, and only there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hotlap.report.page.document import dump_study
from hotlap.report.page.replay import replay_finished
from hotlap.report.page.static import render_static
from hotlap.report.studies_page import row_of
from hotlap.study.glance import Follower
from hotlap.study.kept_guess import find_kept_guess
from plausible_world import PlausibleWorld
from studies import begin, carry, configure

EASY = PlausibleWorld(reach=0.01, noise=0.001)  # every flight passes every gate


def with_guess(factor: float = 2.0):
    """A study that begins elsewhere than at the default weights."""
    asked = configure()
    return replace(asked, first_guess=asked.scenario.space.clip(factor * asked.first_guess))


@pytest.fixture
def kept(tmp_path):
    return carry(tmp_path / "s", with_guess(), EASY)


def test_a_first_guess_that_holds_is_named_with_its_mean_error_beside_that_of_the_default(kept):
    assert np.array_equal(kept.best, kept.configuration.first_guess)
    guess = find_kept_guess(kept.configuration, kept.result, {"tuned": 0.4, "default": 0.053})
    assert guess is not None
    assert guess.words == "the first guess holds already: kept as it is; mean error 0.4 m, that of the default weights 0.053 m"
    assert guess.dump() == {"guess": "first guess", "mean_error": 0.4, "default_mean_error": 0.053}


@pytest.mark.parametrize("errors", [None, {}, {"tuned": 0.4}, {"tuned": 0.4, "default": math.nan}])
def test_an_error_that_is_not_known_is_not_told(kept, errors):
    guess = find_kept_guess(kept.configuration, kept.result, errors)
    assert guess is not None
    assert guess.words == "the first guess holds already: kept as it is"


def test_default_weights_that_hold_are_called_so_also_where_they_were_the_rival(tmp_path):
    asked = configure()
    study = carry(tmp_path / "s", asked, EASY)
    beaten = replace(asked, first_guess=2 * asked.first_guess, rival=asked.first_guess)
    for configuration in (asked, beaten):
        guess = find_kept_guess(configuration, study.result)
        assert guess is not None
        assert guess.words == "the default weights hold already: kept as they are"


def test_what_was_changed_or_does_not_hold_is_not_called_kept(tmp_path, kept):
    assert kept.result is not None
    best = kept.result.best
    changed = replace(kept.result, best=replace(best, parameters=1.5 * best.parameters))
    lost = replace(kept.result, best=replace(best, confirmed=False))
    for result in (changed, lost, None):
        assert find_kept_guess(kept.configuration, result) is None
    assert find_kept_guess(kept.configuration, begin(tmp_path / "new", with_guess()).result) is None


def test_page_and_table_of_studies_say_it(kept):
    replay = replay_finished(kept.configuration, EASY, kept.best)
    said = dump_study(kept, replay)["headline"]["kept_guess"]
    assert said.startswith("the first guess holds already: kept as it is; mean error ")
    assert f"T{said[1:]}." in render_static(kept, replay)
    row = row_of(Follower(kept.folder, "s").look())
    assert row["cells"][1] == "confirmed, nothing changed"


def test_table_of_studies_calls_default_weights_that_were_kept_no_first_guess(tmp_path):
    study = carry(tmp_path / "s", configure(), EASY)
    assert dump_study(study, None)["headline"]["kept_guess"] == "the default weights hold already: kept as they are"
    assert row_of(Follower(study.folder, "s").look())["cells"][1] == "confirmed, nothing changed"


def test_a_study_that_changed_something_says_nothing_of_it(tmp_path):
    study = carry(tmp_path / "s", configure(goal="none"), EASY)
    assert dump_study(study, None)["headline"]["kept_guess"] is None
    assert "kept" not in row_of(Follower(study.folder, "s").look())["cells"][1]
