"""RaceEnv: Gymnasium's checker has nothing to say, and what flies is the built-in world."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import hotlap.gym
from flight.scenarios import TUNED, make_scenario
from hotlap.core.errors import HotlapError
from hotlap.gym import RaceEnv, race_env
from hotlap.gym.piloted import PilotedFlight
from hotlap.worlds.built_in import BuiltIn

NOISE = {"thrust": 0.05, "rates": 0.2, "thrust_bias": 0.02, "position": 0.05, "velocity": 0.1, "attitude": 0.02}


@pytest.fixture
def env(monkeypatch):
    monkeypatch.setattr(race_env, "prepare", lambda race, reference: make_scenario(noise=NOISE))
    return RaceEnv("circle-34")


def test_the_checker_has_nothing_to_say(env):
    check_env(env, skip_render_check=True)


def test_it_is_registered(monkeypatch):
    monkeypatch.setattr(race_env, "prepare", lambda race, reference: make_scenario(noise=NOISE))
    made = gymnasium.make(hotlap.gym.NAME, race="circle-34")
    check_env(made.unwrapped, skip_render_check=True)
    assert made.reset(seed=1)[0].shape == (29,)


def fly(env, seed, action):
    seen, rewards = [env.reset(seed=seed)[0]], []
    while True:
        observation, reward, over, truncated, told = env.step(action)
        seen.append(observation)
        rewards.append(reward)
        assert not truncated
        if over:
            return np.array(seen), np.array(rewards), told


def test_a_flight_depends_on_seed_and_actions_alone(env):
    hover = np.array([-0.2, 0, 0, 0], dtype=np.float32)
    first, again, other = (fly(env, seed, hover) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first[0], again[0])
    np.testing.assert_equal(first[2], again[2])
    assert not np.array_equal(first[0][:5], other[0][:5])


def test_who_does_nothing_misses_a_gate_and_pays(env):
    seen, rewards, told = fly(env, 0, np.zeros(4, dtype=np.float32))
    assert told["completion"] < 1
    assert "ending" in told
    assert rewards[-1] < -race_env.PENALTY / 2
    assert np.isfinite(seen).all()
    with pytest.raises(HotlapError, match="call reset"):
        env.step(np.zeros(4, dtype=np.float32))


@pytest.mark.parametrize("delay", [0.0, 0.013])
def test_the_commands_of_the_controller_fly_the_flight_of_the_world(delay):
    scenario = make_scenario({"delay": delay}, noise=NOISE)
    parameters = np.tile(TUNED, (1, 2, 1))
    flown = BuiltIn().fly(scenario, parameters, np.array([11]), log=[0])
    pilot, record = PilotedFlight(scenario, 11), flown.logs[0]
    np.testing.assert_allclose(pilot.state, record.states[0], atol=1e-6)
    for k in range(60):
        assert not pilot.fly(record.commands[k])
        np.testing.assert_allclose(pilot.state, record.states[k + 1], atol=2e-3)


def test_progress_is_what_the_reward_adds_up_to(env):
    observation, _ = env.reset(seed=3)
    left = env._remaining()
    total = sum(env.step(np.array([0.0, 0, 0.05, 0], dtype=np.float32))[1] for _ in range(30))
    assert total == pytest.approx(left - env._remaining(), abs=1e-9)
    assert observation[:3] == pytest.approx(env._gates[0] - env.scenario.reference.position[0], abs=1.0)


def test_a_render_mode_is_refused():
    with pytest.raises(HotlapError, match="has no render mode 'human'"):
        RaceEnv("circle-34", render_mode="human")
