"""The trajectory of a race: near to it, smooth, as long, and as wrong as it says."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.real_flight.crazyflie.trajectory import ENDS, FINE, MOST, fit
from hotlap.real_flight.paths import with_braking
from real_flight.hangar import make_scenario

REFERENCE = with_braking(make_scenario()).reference
TIMES = REFERENCE.times
STATES = np.hstack([REFERENCE.position, REFERENCE.attitude, REFERENCE.velocity, REFERENCE.rates])
MADE = fit(TIMES, STATES)


def at(made, time, derivative=0):
    """Position of the pieces at a time, from their numbers alone."""
    ends = np.cumsum(made.durations)
    row = min(int(np.searchsorted(ends, time)), len(ends) - 1)
    local = time - (ends[row] - made.durations[row])
    return np.array(
        [
            np.polynomial.Polynomial(one).deriv(derivative)(local) if derivative else np.polynomial.Polynomial(one)(local)
            for one in made.coefficients[row]
        ]
    )


def test_it_is_near_to_the_race_and_as_wrong_as_it_says():
    errors = [np.linalg.norm(at(MADE, time)[:3] - state[:3]) for time, state in zip(TIMES, STATES, strict=True)]
    assert max(errors) == pytest.approx(MADE.error, abs=1e-6)
    speeds = [np.linalg.norm(at(MADE, time, 1)[:3] - state[7:10]) for time, state in zip(TIMES, STATES, strict=True)]
    assert max(speeds) == pytest.approx(MADE.speed_error, abs=1e-6)
    assert max(errors) < FINE
    assert f"{len(MADE.durations)} pieces" in MADE.words


def test_it_lasts_as_long_and_fits_into_the_memory():
    assert MADE.durations.sum() == pytest.approx(TIMES[-1])
    assert len(MADE.durations) <= MOST
    assert 4 * 33 * MOST <= 4096


@pytest.mark.parametrize("derivative", [0, 1, 2, 3])
def test_it_goes_on_smoothly_from_piece_to_piece(derivative):
    scale = max(np.abs(at(MADE, time, derivative)).max() for time in np.linspace(0, TIMES[-1], 50))
    for end in np.cumsum(MADE.durations)[:-1]:
        assert at(MADE, end + 1e-9, derivative) == pytest.approx(at(MADE, end - 1e-9, derivative), abs=1e-5 * max(scale, 1))


def test_it_begins_where_the_race_does_and_ends_at_rest():
    assert at(MADE, 0.0)[:3] == pytest.approx(STATES[0, :3], abs=1 / ENDS)
    assert np.linalg.norm(at(MADE, TIMES[-1] - 1e-9, 1)[:3]) < 0.05


def test_a_heading_that_passes_half_a_turn_goes_on():
    yaw = np.linspace(2.5, 5.0, 301)
    states = np.zeros((301, 13))
    states[:, 3], states[:, 6] = np.cos(yaw / 2), np.sin(yaw / 2)
    made = fit(np.linspace(0, 3, 301), states)
    assert at(made, 3.0)[3] - at(made, 0.0)[3] == pytest.approx(2.5, abs=1e-3)


def test_a_race_of_few_rows_has_few_pieces():
    assert len(fit(TIMES[:40], STATES[:40]).durations) < 5


def test_what_31_pieces_cannot_hold_says_how_wrong_it_is():
    times = np.arange(0, 60, 0.01)
    states = np.zeros((len(times), 13))
    states[:, 0], states[:, 3], states[:, 7] = np.sin(6 * times), 1.0, 6 * np.cos(6 * times)
    made = fit(times, states)
    assert len(made.durations) == MOST
    assert made.error > 0.1
