"""The order in which plans are tried."""

import pytest

from hotlap.analysis.boldest import SHARES, find_boldest, shares_of
from hotlap.files.descriptions import load_race
from hotlap.study.tried_plan import TriedPlan, chosen_of, describe_choice


def plan(share: float, *, holds: bool) -> TriedPlan:
    return TriedPlan(share, 1 / share, 20, 1.0 if holds else 0.5 - share / 10, holds, "" if holds else "gate 3 is missed")


def tried_with(limit: float, attempts: int = 99) -> list[TriedPlan]:
    """What is tried where plans up to a limit hold, by so many attempts."""
    left = iter(range(attempts))
    return find_boldest(SHARES, lambda share: None if next(left, None) is None else plan(share, holds=share <= limit))


@pytest.mark.parametrize("limit", SHARES)
def test_the_boldest_plan_that_holds_is_found(limit):
    found = tried_with(limit)
    chosen = chosen_of(found)
    assert chosen is not None
    assert (chosen.share, chosen.holds) == (limit, True)
    assert len({plan.share for plan in found}) == len(found) <= 6


def test_where_the_boldest_holds_no_other_is_tried():
    assert [plan.share for plan in tried_with(1.0)] == [SHARES[0]]


def test_where_none_holds_the_one_with_the_most_successes_is_chosen():
    chosen = chosen_of(tried_with(0.0))
    assert chosen is not None
    assert chosen.share == min(plan.share for plan in tried_with(0.0))
    assert "none holds" in describe_choice(tried_with(0.0))


def test_the_search_ends_where_no_flights_are_left():
    assert len(tried_with(0.0, attempts=2)) == 2
    assert tried_with(0.0, attempts=0) == []
    assert chosen_of([TriedPlan(0.9, None, 0, None, holds=False, end="no plan")]) is None


def test_the_choice_says_what_a_bolder_plan_fails_at():
    assert describe_choice(tried_with(0.85)) == "planned with 85 % of the thrust: 1.18 s; at 92 % gate 3 is missed"
    assert describe_choice(tried_with(1.0)) == "planned with 92 % of the thrust: 1.09 s, the boldest that is tried"
    assert describe_choice([]) == ""


def test_shares_that_hardly_carry_the_vehicle_are_left_out():
    race = load_race("iros2022")
    lift = race.vehicle.thrust_to_weight
    shares = shares_of(race)
    assert shares
    assert all(share * lift >= 1.15 for share in shares)
    assert shares_of(race, below=0.8) == tuple(share for share in shares if share < 0.8)
