"""The swarm moves by its equation, towards what it found."""

import numpy as np

from hotlap import tuners

from .laws import make_scores
from .test_contract import SPACE, play, start


def flown(name="particle_swarm:log", seed=3):
    swarm = start(name, seed)
    swarm.tell(swarm.ask(10), make_scores(np.arange(10.0)))
    return swarm


def test_a_turn_moves_every_particle_by_the_equation():
    swarm, before = start("particle_swarm:log"), start("particle_swarm:log")
    swarm.tell(swarm.ask(10), make_scores(np.arange(10.0)))
    places, rng = before._places, before._rng
    own, social = rng.random(places.shape), rng.random(places.shape)
    velocity = 1.0 * own * 0.0 + 2.0 * social * (places[0] - places)  # nothing moved yet, so a particle's best place is where it is
    np.testing.assert_allclose(swarm._places, np.clip(places + velocity, 0, 1))


def test_the_leader_stays_after_its_first_turn_and_drifts_on_later():
    swarm = flown()
    np.testing.assert_allclose(swarm._places[0], swarm._best_places[0])


def test_inertia_carries_on_where_nothing_pulls():
    swarm = flown()
    swarm._best_places[:] = swarm._places
    swarm._best_places[:] = swarm._places[0]
    swarm._places[:] = swarm._places[0]
    swarm._velocities[:] = 0.01
    here = swarm._places.copy()
    swarm._move()
    np.testing.assert_allclose(swarm._places, np.clip(here + 0.005, 0, 1))


def test_particles_keep_within_the_box_and_lose_their_speed_at_its_walls():
    swarm = flown()
    swarm._velocities[:] = 10.0
    swarm._move()
    assert (swarm._places == 1).all()
    assert (swarm._velocities == 0).all()


def test_a_turn_may_be_asked_for_in_pieces():
    whole, pieces = start("particle_swarm"), start("particle_swarm")
    np.testing.assert_array_equal(play(whole, 30, n=10), play(pieces, 30, n=3))


def test_the_swarm_gathers_around_the_best():
    swarm = start("particle_swarm:log")
    asked = play(swarm, 400, n=10)
    spread = [np.log(asked[k : k + 10]).std(axis=0).mean() for k in (0, 390)]
    assert spread[1] < 0.2 * spread[0]


def test_the_paper_has_ten_particles():
    assert tuners.build("particle_swarm").settings == type(tuners.build("particle_swarm").settings)(10, 0.5, 1.0, 2.0)
    assert SPACE.size == 5
