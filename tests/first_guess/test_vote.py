"""The parameters that flew best where it was like here win."""

from __future__ import annotations

import numpy as np
import pytest

from first_guess.small import AWAY, DEFAULT, GOOD, HERE, OTHER, make_race, make_set
from hotlap.first_guess.vote import similarity, vote

BOTH = make_set(make_race("a", "080"), make_race("b", "008", features=AWAY))


@pytest.mark.parametrize(("features", "winner"), [(HERE, GOOD), (AWAY, OTHER)])
def test_what_flew_here_wins(features, winner):
    assert vote(BOTH, np.array(features)).tolist() == list(winner)


def test_the_nearer_a_race_the_louder_it_speaks():
    here, away = np.array(HERE), np.array(AWAY)
    shares = [similarity(BOTH, here + share * (away - here))[1] for share in np.linspace(0, 1, 5)]
    assert (np.diff(shares) >= 0).all()
    assert shares[0] < 1e-3 < shares[-2] < shares[-1] == 1.0


def test_what_is_near_a_good_one_has_its_share():
    """One that passes everywhere amid others that do not loses against one amid those that nearly do."""
    lonely, crowd = (200.0, 500.0, 50.0, 10.0, 4.0), [(40.0 * f, 300.0, 30.0, 7.0, 5.0) for f in (0.95, 1.0, 1.05)]
    around = [(200.0 * f, 500.0, 50.0, 10.0, 4.0) for f in (0.95, 1.05)]
    training = make_set(make_race("a", "800777"), candidates=(lonely, *around, *crowd))
    assert tuple(vote(training, np.array(HERE)).tolist()) in crowd


def test_far_from_everything_all_races_speak_alike():
    training = make_set(make_race("a", "800"), make_race("b", "880", features=AWAY), make_race("c", "080"), make_race("d", "080"))
    assert vote(training, np.array(HERE) + 1e6).tolist() == list(GOOD)


def test_passing_more_gates_counts_where_none_passes_all():
    assert vote(make_set(make_race("a", "000", completed="131")), np.array(HERE)).tolist() == list(GOOD)


def test_what_is_the_same_in_all_races_tells_nothing():
    other = np.array(HERE) * [1, 1, 1, 1, 2]
    assert similarity(make_set(make_race("a", "008")), other).tolist() == similarity(make_set(make_race("b", "008")), other).tolist()
    assert vote(make_set(make_race("a", "800")), other).tolist() == list(DEFAULT)
