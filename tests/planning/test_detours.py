"""Ways around solids are short, free, and found where there is one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.planning.detours import along, find_way

START, END = np.array([0.0, 0.0, 0.0]), np.array([6.0, 0.0, 0.0])


class Balls:
    """Balls with places around them."""

    def __init__(self, *balls: tuple[tuple[float, float, float], float]) -> None:
        self.balls = [(np.array(centre), radius) for centre, radius in balls]

    def lacks(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        each = np.stack([radius - np.linalg.norm(points - centre, axis=1) for centre, radius in self.balls])
        return each.max(axis=0), each.argmax(axis=0)

    def beside(self, index: int, heights: np.ndarray) -> np.ndarray:  # noqa: ARG002  they end
        centre, radius = self.balls[index]
        angles = np.linspace(0, 2 * np.pi, 16, endpoint=False)
        flat = np.stack([np.cos(angles), np.sin(angles), np.zeros(16)], axis=1)
        places = np.vstack([centre + 1.1 * radius * flat, centre + 1.1 * radius * flat[:, [0, 2, 1]]])
        return places[self.lacks(places)[0] <= 0]


def length(way: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def test_a_free_way_is_straight():
    assert_allclose(find_way(Balls(((3.0, 2.0, 0.0), 1.0)), START, END), [START, END])


def test_a_way_around_two_balls_is_free_and_not_much_longer():
    space = Balls(((2.0, 0.1, 0.0), 0.8), ((4.0, -0.1, 0.0), 0.8))
    way = find_way(space, START, END)
    assert way is not None
    places, directions = along(way, np.linspace(0, 1, 400))
    assert space.lacks(places)[0].max() <= 1e-9
    assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    assert 6.0 < length(way) < 7.5


def test_the_nearer_side_is_taken():
    way = find_way(Balls(((3.0, 0.5, 0.0), 1.0)), START, END)
    assert way is not None
    assert way[1:-1, 1].max() < 0


@pytest.mark.parametrize("place", [START, END])
def test_there_is_no_way_from_or_to_what_is_enclosed(place):
    assert find_way(Balls((tuple(place), 1.0)), START, END) is None


def test_shares_of_a_way_are_those_of_its_length():
    way = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0]])
    places, directions = along(way, np.array([0.0, 0.5, 0.75, 1.0]))
    assert_allclose(places, [[0, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0]])
    assert_allclose(directions[[1, 3]], [[1, 0, 0], [0, 1, 0]])
