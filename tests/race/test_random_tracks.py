"""Random tracks are tracks, and the same seed is the same track."""

import numpy as np
import pytest

from hotlap.race.random_tracks import GATES, TrackStyle, random_track

SEEDS = range(40)


@pytest.mark.parametrize("layout", TrackStyle)
def test_a_seed_is_a_track_and_another_seed_another(layout):
    assert random_track(3, layout) == random_track(3, layout)
    assert random_track(3, layout) != random_track(4, layout)


def test_layouts_are_drawn_from_the_seed_too():
    assert {random_track(seed).name.split("-")[0] for seed in SEEDS} == set(TrackStyle)


def test_numbers_of_gates_and_their_distances_are_a_races():
    for seed in SEEDS:
        track = random_track(seed)
        assert GATES[0] <= len(track.gates) <= GATES[1]
        legs = np.linalg.norm(np.diff(np.vstack([track.start, track.waypoints]), axis=0), axis=1)
        assert 1.0 < legs.min() <= legs.max() < 35.0


def test_a_track_begins_facing_its_first_gate():
    for seed in SEEDS:
        track = random_track(seed)
        w, _, _, z = track.attitude
        heading = np.array([w * w - z * z, 2 * w * z])
        ahead = (track.gate_positions[0] - track.start)[:2]
        assert heading @ ahead == pytest.approx(np.linalg.norm(ahead))


def test_layouts_are_what_they_are_called():
    def heights(layout):
        tracks = [random_track(seed, layout) for seed in SEEDS]
        return [np.vstack([track.start, track.waypoints])[:, 2] for track in tracks]

    assert max(np.ptp(height) for height in heights(TrackStyle.FLAT)) < 8
    assert min(height[-1] - height[0] for height in heights(TrackStyle.CLIMB)) > 0
    assert np.median([np.diff(height).min() for height in heights(TrackStyle.DROP)]) < -5
    assert min(np.ptp(height) for height in heights(TrackStyle.LOOP)) > 5


def test_flat_and_spiral_turn_and_a_spiral_turns_one_way():
    for seed in SEEDS:
        points = np.vstack([random_track(seed, TrackStyle.SPIRAL).start, random_track(seed, TrackStyle.SPIRAL).waypoints])[:, :2]
        legs = np.diff(points, axis=0)
        turns = np.sign(legs[:-1, 0] * legs[1:, 1] - legs[:-1, 1] * legs[1:, 0])
        assert abs(turns.sum()) > 0.6 * len(turns)
