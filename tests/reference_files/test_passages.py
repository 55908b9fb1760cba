"""Gate times are the cheapest ascending choice of closest approaches."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from hotlap.race.race import GateRule, Race
from hotlap.race.track import Gate
from hotlap.reference_files.passages import MissedGateError, Target, find_passages, targets_of
from planning import small

TIMES = 0.01 * np.arange(1001)


def fly(position: np.ndarray, gates: list[list[float]], distance: float = 1.3) -> np.ndarray:
    targets = [Target(f"gate {k}", np.array(gate), distance) for k, gate in enumerate(gates, 1)]
    return find_passages(TIMES, position, np.gradient(position, 0.01, axis=0), targets)


def eight() -> np.ndarray:
    """A figure of eight in 10 s, through its centre at 0, 5 and 10 s; the rightmost point at 1.25 s or so, the leftmost at 6.25 s."""
    angle = 2 * np.pi * TIMES / 10
    return np.stack([10 * np.sin(angle), 5 * np.sin(2 * angle), np.zeros_like(angle)], axis=1)


def line() -> np.ndarray:
    """2 m/s along x."""
    return np.stack([2 * TIMES, np.zeros_like(TIMES), np.zeros_like(TIMES)], axis=1)


def test_a_gate_beside_a_line_is_passed_at_the_foot_of_the_perpendicular():
    assert_allclose(fly(line(), [[3.001, 1.0, 0.0], [7.777, 0.0, -1.2]]), [1.5005, 3.8885], atol=1e-9)


def test_the_crossing_of_an_eight_is_passed_in_the_turn_of_its_gate():
    right, centre, left = [10.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-10.0, 0.0, 0.0]
    assert_allclose(fly(eight(), [right, centre, left]), [2.5, 5.0, 7.5], atol=1e-6)
    assert_allclose(fly(eight(), [right, left, centre]), [2.5, 7.5, 10.0], atol=1e-6)
    assert_allclose(fly(eight(), [centre, right, centre, left, centre]), [0.0, 2.5, 5.0, 7.5, 10.0], atol=1e-6)


def test_a_fly_by_is_not_taken_for_the_passage():
    there_and_back = line()
    there_and_back[500:] = there_and_back[500::-1]
    there_and_back[:, 1] = np.where(TIMES < 5, 1.0, 0.0)  # 1 m beside the gate on the way there
    assert_allclose(fly(there_and_back, [[4.0, 0.0, 0.0]]), [8.0], atol=1e-6)
    assert_allclose(fly(there_and_back, [[4.0, 0.0, 0.0], [9.0, 1.0, 0.0]]), [2.0, 4.5], atol=1e-6)


def test_a_gate_that_is_passed_too_far_away_is_named_with_its_distance():
    with pytest.raises(MissedGateError, match=r"gate 2: is passed at 1\.50 m; judge\.distance = 1\.3 m is the most"):
        fly(line(), [[3.0, 0.0, 0.0], [7.0, 1.5, 0.0]])


def test_a_gate_that_is_passed_only_before_its_turn_is_named():
    with pytest.raises(MissedGateError, match=r"gate 2: is not passed after gate 1, only before it"):
        fly(line(), [[7.0, 0.0, 0.0], [3.0, 0.0, 0.0]])


def test_the_start_and_the_end_may_be_closest():
    assert_allclose(fly(line(), [[-0.5, 0.0, 0.0], [20.5, 0.0, 0.0]]), [0.0, 10.0])


def test_hovering_at_a_gate_passes_it():
    assert len(fly(np.zeros((1001, 3)), [[0.5, 0.0, 0.0]])) == 1


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_no_other_ascending_choice_of_approaches_is_cheaper(seed, count):
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * TIMES[:, None] / 10 * rng.integers(1, 5, size=3)
    position = 2 * np.sin(angle + rng.uniform(0, 6, size=3))
    gates = rng.normal(size=(count, 3))
    distances = np.linalg.norm(position[:, None] - gates, axis=2)
    padded = np.vstack([np.full(count, np.inf), distances, np.full(count, np.inf)])
    minima = [np.flatnonzero((padded[:-2, g] >= distances[:, g]) & (padded[2:, g] > distances[:, g])) for g in range(count)]
    sums = [
        sum(distances[row, gate] ** 2 for gate, row in enumerate(rows))
        for rows in product(*minima)
        if all(distances[row, gate] < 1.5 for gate, row in enumerate(rows)) and all(np.diff(rows) > 0)
    ]
    try:
        passages = fly(position, gates.tolist(), distance=1.5)
    except MissedGateError:
        assert not sums
        return
    found = np.stack([np.interp(passages, TIMES, column) for column in position.T], axis=1)
    assert ((found - gates) ** 2).sum() <= min(sums) + 0.02


def opened(*gates: dict, **race) -> Race:
    """A race through gates with openings."""
    base = small.RACES["drag"]
    track = base.track.model_copy(update={"gates": tuple(Gate.model_validate(gate) for gate in gates), "end": None})
    judge = base.judge.model_copy(update={"rule": GateRule.OPENING, "distance": 1.3})
    return base.model_copy(update={"track": track, "judge": judge, **race})


def through(race: Race, position: np.ndarray) -> np.ndarray:
    return find_passages(TIMES, position, np.gradient(position, 0.01, axis=0), targets_of(race))


def hole(x: float, y: float = 0.0, **keys) -> dict:
    """A square hole of 1 m that is passed along x."""
    return {"position": (x, y, 0.0), "yaw": 0.0, "side": 1.0, **keys}


def test_an_opening_is_passed_where_its_plane_is_crossed():
    assert_allclose(through(opened(hole(3.003), hole(7.0, 0.1)), line()), [1.5015, 3.5], atol=1e-9)


def test_an_opening_is_smaller_by_the_radius_of_the_vehicle():
    radius = opened(hole(3.0)).vehicle.outer_radius
    through(opened(hole(3.0, 0.49 - radius)), line())
    with pytest.raises(
        MissedGateError, match=rf"gate 2: is passed 0\.11 m outside of what its opening leaves to a vehicle of {radius:g} m"
    ):
        through(opened(hole(3.0), hole(7.0, 0.61 - radius)), line())


def test_a_gate_is_passed_in_its_direction():
    back = line()[::-1]
    for gate in (hole(3.0, direction="backward"), hole(3.0, direction="either"), hole(3.0, yaw=np.pi)):
        assert_allclose(through(opened(gate), back), [8.5], atol=1e-9)
    with pytest.raises(MissedGateError, match="gate 1: is passed backwards; turn its yaw by pi, or set its direction"):
        through(opened(hole(3.0)), back)


def test_a_gate_that_is_passed_sideways_is_said():
    with pytest.raises(MissedGateError, match="gate 1: is passed sideways, 90 degrees off its normal"):
        through(opened(hole(3.0, yaw=np.pi / 2)), line() + [0.0, 0.1, 0.0])


def test_a_gate_far_away_is_said_with_its_distance():
    with pytest.raises(MissedGateError, match=r"gate 1: is not passed: the reference comes no nearer than 5\.00 m to its centre"):
        through(opened(hole(3.0, 5.0)), line())


def test_the_way_back_through_a_gate_is_not_its_passage():
    there_and_back = line()
    there_and_back[500:] = there_and_back[500::-1]
    back = hole(4.0, direction="backward")
    assert_allclose(through(opened(hole(4.0), back), there_and_back), [2.0, 8.0], atol=0.02)
    with pytest.raises(MissedGateError, match="gate 2: is not passed after gate 1, only before it"):
        through(opened(back, hole(4.0)), there_and_back)


def test_of_several_crossings_of_an_opening_the_one_nearest_to_its_middle_counts():
    there_and_back = line()
    there_and_back[500:] = there_and_back[500::-1]
    there_and_back[:, 1] = np.where(TIMES < 5, 0.1, 0.0)
    assert_allclose(through(opened(hole(4.003, direction="either")), there_and_back), [7.9985], atol=1e-6)


def test_a_plan_that_ends_on_the_plane_of_its_last_gate_passes_it():
    assert_allclose(through(opened(hole(3.0), hole(20.0 + 1e-4)), line()), [1.5, 10.0], atol=1e-3)


def test_a_gate_with_an_orientation_alone_is_a_circle_of_the_judges_distance():
    bare = {"position": (3.0, 1.2, 0.0), "yaw": 0.0}
    assert_allclose(through(opened(bare), line()), [1.5], atol=1e-9)
    with pytest.raises(MissedGateError, match=r"gate 1: is passed 1\.40 m from its centre; judge\.distance = 1\.3 m is the most"):
        through(opened({**bare, "position": (3.0, 1.4, 0.0)}), line())


def test_a_ball_counts_by_its_own_radius():
    ball = {"position": (3.0, 0.4, 0.0), "radius": 0.5}
    assert_allclose(through(opened(hole(1.0), ball), line()), [0.5, 1.5], atol=1e-9)
    with pytest.raises(MissedGateError, match=r"gate 2: is passed at 0\.40 m; the gate's radius = 0\.3 m is the most that counts"):
        through(opened(hole(1.0), {**ball, "radius": 0.3}), line())


def test_other_rules_count_distances_alone():
    race = opened(hole(3.0, 1.0, direction="backward"))
    by_clock = race.model_copy(update={"judge": race.judge.model_copy(update={"rule": GateRule.CLOCK})})
    assert_allclose(through(by_clock, line()), [1.5], atol=1e-9)


def test_points_that_do_not_count_are_no_targets_and_laps_have_names():
    race = opened(hole(3.0), {"position": (5.0, 0.0, 0.0), "counts": False}, hole(7.0))
    assert [target.name for target in targets_of(race)] == ["gate 1", "gate 2"]
    laps = race.model_copy(update={"track": race.track.model_copy(update={"laps": 2})})
    assert [target.name for target in targets_of(laps)][2:] == ["gate 1 of lap 2", "gate 2 of lap 2"]


def test_a_tunnel_is_passed_inside_from_end_to_end():
    slanting = line() + np.column_stack([0 * TIMES, 0.2 * (2 * TIMES - 6.0), 0 * TIMES])  # through the middle of a gate at x = 6
    radius = opened(hole(6.0)).vehicle.outer_radius
    room = 0.5 - radius
    assert_allclose(through(opened(hole(6.0, depth=2 * (room / 0.2 - 0.1))), slanting), [3.0], atol=1e-9)
    with pytest.raises(MissedGateError, match=r"gate 1: is passed 0\.02 m outside of what its opening leaves"):
        through(opened(hole(6.0, depth=2 * (room / 0.2 + 0.1))), slanting)
