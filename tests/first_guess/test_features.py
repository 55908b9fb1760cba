"""Features are what their names say, and do not depend on where a track lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import make_scenario
from flight import scenarios
from hotlap.first_guess.features import OF_A_PIECE, OF_A_RACE, PAPER, piece_features, race_features
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.reference.scenario import Scenario

EVERY = (*OF_A_PIECE, *OF_A_RACE)


def climbing(speed: float, slope: float, acceleration: float = 0.0) -> Scenario:
    """A straight line, with a first piece of 2.5 s."""
    scenario = make_scenario()
    t = scenario.reference.times
    along = speed * t + acceleration * t**2 / 2
    way = np.array([np.cos(slope), 0.0, np.sin(slope)])
    velocity = (speed + acceleration * t)[:, None] * way
    return replace(scenario, reference=replace(scenario.reference, position=along[:, None] * way, velocity=velocity))


def test_the_five_of_the_paper_on_a_straight_line():
    points, slope, rise, speed, acceleration = piece_features(climbing(4.0, 0.3, 2.0), PAPER)[0]
    assert points == 251  # rows every 10 ms, both ends counted
    assert slope == pytest.approx(0.3)
    assert rise == pytest.approx((4 * 2.5 + 2.5**2) * np.sin(0.3))
    assert speed == pytest.approx(4 + 2.5)
    assert acceleration == pytest.approx(2.0)


@pytest.mark.parametrize("slope", [np.pi / 2, -np.pi / 2])
def test_a_vertical_piece_has_a_slope(slope):
    assert piece_features(climbing(4.0, slope), ("slope",))[0, 0] == pytest.approx(slope)


def test_there_is_a_row_for_each_piece_and_one_for_the_race():
    scenario = scenarios.make_scenario()
    assert piece_features(scenario, EVERY).shape == (len(scenario.segments.pieces), len(EVERY))
    assert race_features(scenario, EVERY).shape == (len(EVERY),)
    assert np.isfinite(piece_features(scenario, EVERY)).all()
    rows = piece_features(scenario, tuple(OF_A_RACE))
    np.testing.assert_array_equal(rows, np.tile(race_features(scenario, tuple(OF_A_RACE)), (2, 1)))


def test_moving_and_turning_a_track_changes_nothing():
    scenario = scenarios.make_scenario()
    reference, turn = scenario.reference, np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    moved = replace(reference, position=reference.position @ turn.T + [5, -3, 2], velocity=reference.velocity @ turn.T)
    np.testing.assert_allclose(piece_features(replace(scenario, reference=moved), EVERY), piece_features(scenario, EVERY), atol=1e-9)


def test_rows_at_another_period_change_nothing():
    usual = climbing(4.0, 0.3, 2.0)
    rows = {name: getattr(usual.reference, name)[::2] for name in ("position", "attitude", "velocity", "rates", "thrust", "rotor_thrusts")}
    coarse = replace(usual, reference=replace(usual.reference, **rows, period=2 * usual.reference.period))
    np.testing.assert_allclose(piece_features(coarse, PAPER)[0], piece_features(usual, PAPER)[0], rtol=1e-2)


def test_who_flies_is_told():
    late = scenarios.make_scenario(vehicle={"delay": 0.04}, model={"delay": 0.03}, judge={"rule": GateRule.CLOSEST})
    weight, delay, response, closest = race_features(late, tuple(OF_A_RACE))
    assert weight == pytest.approx(late.race.vehicle.thrust_to_weight)
    assert delay == pytest.approx(0.01)
    assert response == pytest.approx(0.07 + 0.01875)
    assert closest == 1.0
    blind = scenarios.make_scenario(vehicle={"delay": 0.04}, model={"delay": 0.03}, controller={"predict": False})
    assert race_features(blind, ("unknown_delay", "closest")).tolist() == [pytest.approx(0.04), 0.0]


def test_a_piece_of_no_time_has_features():
    scenario = make_scenario(JudgeSettings())
    short = replace(scenario, segments=replace(scenario.segments, starts=np.array([0.0, 5.0])))
    assert np.isfinite(piece_features(short, EVERY)).all()
