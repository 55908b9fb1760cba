"""Detailed plants have the rotors, mixers and rate loops of a quadrotor's file, and fly as the plain plant where it says no more."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from hotlap.dynamics.mixers import LEAST_THROTTLE, Mixer
from hotlap.flight.detailed_plant import detailed_vehicle_numbers
from hotlap.race.plant_kind import PLAIN, detailed_kind, plant_kind_of
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.rate_loop import LIMITS, Output, RateLoop
from hotlap.race.vehicle_parameters import COLUMNS, scale, vehicle_parameters_of

from .open_loop import REST, OpenLoop

pytestmark = pytest.mark.check  # each kind of plant is compiled

DRONE: dict[str, Any] = {"name": "box", "mass": 0.9, "inertia": (0.004, 0.006, 0.009), "arm": 0.2, "torque_ratio": 0.02}
LEVER = 0.2 * np.sqrt(0.5)
IN_X = ((LEVER, LEVER, 1.0), (LEVER, -LEVER, -1.0), (-LEVER, -LEVER, 1.0), (-LEVER, LEVER, -1.0))
LARGEST = 6.0


def drone(**says: Any) -> Quadrotor:
    return Quadrotor(**{**DRONE, "rotor_thrust": (0.1, LARGEST), "motor_time": (0.02, 0.05), **says})


def ring(rotors: int, turned: float = 0.5) -> tuple[tuple[float, float, float], ...]:
    """Rotors at equal angles, neighbours turning against each other."""
    angles = 2 * np.pi * (np.arange(rotors) + turned) / rotors
    return tuple((0.2 * np.cos(a), 0.2 * np.sin(a), (-1.0) ** k) for k, a in enumerate(angles))


QUICK = drone(motor_time=(0.0, 0.0), rotor_thrust=(0.0, LARGEST))


def asked(quadrotor: Quadrotor, thrust: float, *rates: float) -> np.ndarray:
    """Shares of the largest thrust that the rotors of a level drone at rest give after a step, for a share of the whole thrust."""
    vehicle = OpenLoop(quadrotor)
    vehicle.fly([thrust * quadrotor.max_acceleration, *rates])
    return vehicle.thrusts / LARGEST


WILD = [[14.0, 3.0, -2.0, 1.0], [4.0, -9.0, 9.0, 3.0], [30.0, 1.0, 9.0, -3.0], [9.0, 0.0, 0.0, 0.0]]


def test_a_list_of_the_rotors_of_an_x_flies_as_the_x():
    plain, listed = drone(drag=(0.3, 0.2, 0.1), rotor_drag=0.02), drone(drag=(0.3, 0.2, 0.1), rotor_drag=0.02, rotors=IN_X)
    assert plant_kind_of(plain) == PLAIN != plant_kind_of(listed)
    one, other = OpenLoop(plain), OpenLoop(listed)
    for command in WILD:
        assert_allclose(one.fly(command, 20), other.fly(command, 20), atol=1e-9)
        assert_allclose(one.thrusts, other.thrusts, atol=1e-9)


@pytest.mark.parametrize("rotors", [5, 6, 8])
def test_more_rotors_share_thrust_and_torques(rotors):
    """With rotors that are not at their limits, a vehicle flies as one of four of the same mass, inertia and lags."""
    many = drone(rotors=ring(rotors), rotor_thrust=(0.0, 20.0), motor_time=(0.0, 0.0))
    four = drone(rotor_thrust=(0.0, 30.0), motor_time=(0.0, 0.0))
    one, other = OpenLoop(many), OpenLoop(four)
    for command in [[14.0, 1.0, -0.5, 0.2], [8.0, -0.5, 0.5, -0.2]]:
        assert_allclose(one.fly(command, 20), other.fly(command, 20), atol=1e-6)
    assert len(one.thrusts) == rotors


@pytest.mark.parametrize("age", [0.0025, 0.004, 0.009])
def test_a_loop_with_dead_time_acts_on_rates_that_are_so_old(age):
    """The first torque against a rate that is lost at once: so long the rotors do what they did."""
    now, late = OpenLoop(QUICK.model_copy(update={"rotors": IN_X})), OpenLoop(QUICK.model_copy(update={"rate_delay": age}))
    hover = [QUICK.gravity, 0, 0, 0]
    for vehicle in (now, late):
        vehicle.fly(hover)
        vehicle.memory.state[10, 0] = 0.4
    turned = [now.fly(hover, 8)[:, 10], late.fly(hover, 8)[:, 10]]
    steps = round(np.floor(age / 0.0025 + 1e-9))
    assert_allclose(turned[1][:steps], 0.4, atol=1e-9)
    assert turned[1][steps] < 0.4 - 1e-3
    assert turned[0][0] < 0.4 - 1e-3


@pytest.mark.parametrize("mixer", Mixer)
@pytest.mark.parametrize("loop", [None, RateLoop(p=(0.1, 0.1, 0.2)), RateLoop(p=(0.1, 0.1, 0.2), output=Output.SPEED, idle=0.05)])
def test_rotor_thrusts_keep_their_limits(mixer, loop):
    vehicle = OpenLoop(drone(mixer=mixer, rate_loop=loop, rotors=IN_X))
    for command in WILD:
        for _ in range(20):
            vehicle.fly(command)
            assert vehicle.thrusts.min() >= 0.1 * (1 - 1e-9)
            assert vehicle.thrusts.max() <= LARGEST * (1 + 1e-9)


@pytest.mark.parametrize("mixer", Mixer)
def test_mixers_agree_as_long_as_no_rotor_meets_a_limit(mixer):
    quadrotor = QUICK.model_copy(update={"mixer": mixer, "rotors": IN_X})
    assert_allclose(asked(quadrotor, 0.5, 0.4, -0.2, 0.1), asked(QUICK, 0.5, 0.4, -0.2, 0.1), atol=1e-9)


def test_scaling_gives_thrust_away_at_the_top_and_gains_it_at_the_bottom():
    scaling = QUICK.model_copy(update={"mixer": Mixer.SCALE})
    free = QUICK.model_copy(update={"rotor_thrust": (0.0, 3 * LARGEST)})
    wanted = OpenLoop(free)
    wanted.fly([0.95 * QUICK.max_acceleration, 3.0, 0, 0])
    top = asked(scaling, 0.95, 3.0, 0, 0)
    assert_allclose(top, wanted.thrusts / wanted.thrusts.max(), rtol=1e-9)
    bottom = asked(scaling, 0.06, 3.0, 0, 0)
    assert bottom.min() == pytest.approx(0.0, abs=1e-12)
    assert bottom.mean() > 0.065
    assert np.ptp(bottom) == pytest.approx(np.ptp(asked(QUICK, 0.5, 3.0, 0, 0)))
    assert_allclose(asked(scaling, 0.98 * LEAST_THROTTLE, 2.0, 0, 0), 0.98 * LEAST_THROTTLE, atol=1e-9)


def test_airmode_moves_the_throttle_so_that_torques_fit():
    airmode = QUICK.model_copy(update={"mixer": Mixer.BETAFLIGHT})
    spread = np.ptp(asked(QUICK, 0.5, 3.0, 0, 0))
    for throttle in (0.02, 0.5, 0.99):
        shares = asked(airmode, throttle, 3.0, 0, 0)
        assert np.ptp(shares) == pytest.approx(spread)
        assert shares.mean() == pytest.approx(np.clip(throttle, spread / 2, 1 - spread / 2))
    assert np.ptp(asked(airmode, 0.5, 60.0, 60.0, 0)) == pytest.approx(1.0)  # more than the whole range
    assert np.ptp(asked(airmode, 0.5, 0, 0, 60.0)) == pytest.approx(2 * LIMITS[2])


def signals(quadrotor: Quadrotor, loop: RateLoop, mixer: Mixer, throttle: float, *rates: float) -> np.ndarray:
    """Signals of the rotors, from 0 to 1, after a step, at a throttle."""
    output = loop.idle + (1 - loop.idle) * throttle
    share = output**2 if loop.output is Output.SPEED else output
    shares = asked(quadrotor.model_copy(update={"rate_loop": loop, "mixer": mixer}), share, *rates)
    outputs = np.sqrt(shares) if loop.output is Output.SPEED else shares
    return (outputs - loop.idle) / (1 - loop.idle)


BETAFLIGHT = RateLoop(p=(0.1, 0.1, 0.2), limit=LIMITS, output=Output.SPEED, idle=0.055)
MIX = np.array([[1, -1, 1], [-1, -1, -1], [-1, 1, 1], [1, 1, -1]])  # of roll, pitch and yaw: front left, front right, back right, back left


@pytest.mark.parametrize("throttle", [0.0, 0.2, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("rates", [(1.0, 0.0, 0.0), (2.0, -1.5, 1.0), (9.0, 9.0, 9.0), (0.0, 0.0, 5.0)])
def test_betaflights_mixer_works_on_motor_outputs(throttle, rates):
    """Limits of each axis, range normalised to 1, throttle within what the mix leaves."""
    turn = MIX @ np.clip(np.multiply(BETAFLIGHT.p, rates), np.negative(LIMITS), LIMITS)
    turn = turn / max(np.ptp(turn), 1.0)
    expected = np.clip(throttle, -turn.min(), 1 - turn.max()) + turn
    assert_allclose(signals(QUICK, BETAFLIGHT, Mixer.BETAFLIGHT, throttle, *rates), expected, atol=1e-7)


@pytest.mark.parametrize("loop", [RateLoop(p=(0.1, 0.1, 0.2)), BETAFLIGHT])
def test_the_gain_in_hover_is_what_a_small_error_is_answered_with(loop):
    quadrotor = QUICK.model_copy(update={"rate_loop": loop})
    for axis in range(3):
        command = np.array([quadrotor.gravity, 0.0, 0.0, 0.0])
        command[1 + axis] = 1e-3
        turned = OpenLoop(quadrotor).fly(command)[-1, 10 + axis]
        assert turned / (1e-3 * 0.0025) == pytest.approx(quadrotor.hover_rate_gain[axis], rel=1e-3)


def test_a_flight_with_other_gains_has_the_signals_of_a_pid_loop_scaled():
    """As `--hold "rate_gain=-20%"` asks for."""
    quadrotor = QUICK.model_copy(update={"rate_loop": RateLoop(p=(0.1, 0.1, 0.2))})
    turned = []
    for factor in (1.0, 0.8):
        vehicle, row = OpenLoop(quadrotor), vehicle_parameters_of(quadrotor)[None]
        weaker = scale(row, COLUMNS["rate_gain"], factor)
        vehicle.memory.vehicle[:, 0] = detailed_vehicle_numbers(weaker, quadrotor)[0]
        turned.append(vehicle.fly([quadrotor.gravity, 0.1, 0.1, 0.1])[-1, 10:])
    assert_allclose(turned[1], 0.8 * turned[0], rtol=1e-5)


def test_with_signals_for_speed_the_gain_grows_with_throttle():
    quadrotor = QUICK.model_copy(update={"rate_loop": BETAFLIGHT})
    turned = [OpenLoop(quadrotor).fly([thrust, 0.1, 0, 0])[-1, 10] for thrust in (5.0, 20.0)]
    assert turned[1] / turned[0] == pytest.approx(2.0, rel=1e-3)  # as the root of the thrust


def test_an_integral_part_takes_away_what_pushes_for_good():
    """A rotor that is too heavy for its place: with a proportional loop a rate is left over."""
    loop = RateLoop(p=(0.02, 0.02, 0.05), i=(0.0, 0.0, 0.0))
    left = []
    for i in (0.0, 0.3):
        quadrotor = QUICK.model_copy(update={"rate_loop": loop.model_copy(update={"i": (i, i, i)})})
        vehicle = OpenLoop(quadrotor)
        vehicle.memory.vehicle[4 : 4 + 4, 0] += 0.002  # m: the centre of mass is to the right
        left.append(abs(vehicle.fly([quadrotor.gravity, 0, 0, 0], 800)[-1, 10]))
    assert left[0] > 0.05
    assert left[1] < 1e-3


def test_an_integral_part_has_its_limit():
    loop = RateLoop(p=(1e-6, 1e-6, 1e-6), i=(5.0, 5.0, 5.0), integral_limit=0.1)
    vehicle = OpenLoop(QUICK.model_copy(update={"rate_loop": loop, "inertia": (4.0, 6.0, 9.0)}))
    vehicle.fly([0.5 * QUICK.max_acceleration, 5.0, 0, 0], 100)
    assert_allclose(vehicle.thrusts / LARGEST, 0.5 + 0.1 * MIX[:, 0], atol=1e-3)


@pytest.mark.parametrize("cutoff", [0.0, 20.0])
def test_a_derivative_part_brakes_and_its_filter_takes_time(cutoff):
    loop = RateLoop(p=(1e-9, 1e-9, 1e-9), d=(0.002, 0.002, 0.002), d_cutoff=cutoff)
    vehicle = OpenLoop(QUICK.model_copy(update={"rate_loop": loop, "inertia": (40.0, 60.0, 90.0)}))
    vehicle.fly([0.5 * QUICK.max_acceleration, 0, 0, 0])
    vehicle.memory.state[10, 0] = 0.1  # a jump of the rate: a slope of 40 rad/s^2 in one step
    vehicle.fly([0.5 * QUICK.max_acceleration, 0, 0, 0])
    share = 1.0 if cutoff == 0 else 1 - np.exp(-2 * np.pi * cutoff * 0.0025)
    assert_allclose(vehicle.thrusts / LARGEST, 0.5 - share * 0.002 * 40 * MIX[:, 0], atol=1e-6)


def test_thrust_that_lags_follows_exponentially():
    vehicle = OpenLoop(drone(motor_lag="thrust"))
    first, steps = vehicle.thrusts[0], 12
    vehicle.fly([14.0, 0, 0, 0], steps)
    last = 0.9 * 14.0 / 4
    assert_allclose(vehicle.thrusts, last + (first - last) * np.exp(-steps * 0.0025 / 0.02), rtol=1e-9)


SPINNING = {"rotor_inertia": 2e-4, "rotor_speed": 800.0}


def angular_momentum(vehicle: OpenLoop, quadrotor: Quadrotor) -> np.ndarray:
    """Of body and rotors (world)."""
    state = vehicle.state
    speeds = quadrotor.rotor_speed * np.sqrt(vehicle.thrusts / quadrotor.rotor_thrust[1])
    carried = -(quadrotor.rotor_spins @ speeds) * quadrotor.rotor_inertia
    return Rotation.from_quat(np.roll(state[3:7], -1)).apply(np.array(quadrotor.inertia) * state[10:13] + [0, 0, carried])


def test_rotors_and_body_share_their_angular_momentum():
    """Without thrust on the levers and torque of the air nothing changes the sum; what a rotor gains, the body loses."""
    quadrotor = drone(**SPINNING, rate_gain=(2.0, 2.0, 2.0), rotor_thrust=(0.0, LARGEST))
    vehicle = OpenLoop(quadrotor, step=5e-4)
    vehicle.memory.vehicle[4:16] = 0.0  # torques of the air
    vehicle.memory.state[10:13, 0] = (3.0, -2.0, 1.0)
    before = angular_momentum(vehicle, quadrotor)
    states = vehicle.fly([10.0, 1.0, -1.0, 3.0], 400)
    assert np.ptp(vehicle.thrusts) > 0.2
    assert np.abs(states[-1, 10:] - [3.0, -2.0, 1.0]).max() > 0.5
    assert_allclose(angular_momentum(vehicle, quadrotor), before, atol=2e-4)


def test_spinning_up_turns_the_body_before_the_air_does():
    command = np.array([QUICK.gravity, 0, 0, 1.0])
    with_momentum, without = (OpenLoop(drone(**more, rotors=IN_X)).fly(command, 2)[-1, 12] for more in (SPINNING, {}))
    assert with_momentum > 1.5 * without > 0


def test_inflow_takes_thrust_from_a_climb_and_gives_it_to_a_fall():
    quadrotor = drone(inflow=0.05)
    for speed in (-5.0, 5.0):
        state = REST.copy()
        state[9] = speed
        vehicle = OpenLoop(quadrotor, state)
        change = (vehicle.fly([quadrotor.gravity, 0, 0, 0])[-1, 9] - speed) / 0.0025
        hover = quadrotor.mass * quadrotor.gravity / 4
        assert change == pytest.approx(-4 * 0.05 * np.sqrt(hover) * speed / quadrotor.mass, rel=0.01)


def test_inflow_damps_a_turn():
    """A rotor at y that rises with w y loses inflow s w y of its thrust: the torque is -sum y^2 inflow s w."""
    quadrotor = QUICK.model_copy(update={"inflow": 0.05, "rate_gain": (1e-6, 1e-6, 1e-6)})
    state = REST.copy()
    state[10] = 2.0
    change = (OpenLoop(quadrotor, state).fly([quadrotor.gravity, 2.0, 0, 0])[-1, 10] - 2.0) / 0.0025
    torque = -4 * LEVER**2 * 0.05 * np.sqrt(quadrotor.mass * quadrotor.gravity / 4) * 2.0
    assert change == pytest.approx(torque / quadrotor.inertia[0], rel=0.01)


def test_kinds_are_told_by_their_names():
    quadrotor = drone(mixer="scale", rate_loop=RateLoop(p=(0.1, 0.1, 0.1)), rotors=ring(6))
    kind = detailed_kind(plant_kind_of(quadrotor))
    assert (kind.mixer, kind.pid, kind.rotors) == (Mixer.SCALE, True, 6)
    assert str(kind) == plant_kind_of(quadrotor)


SAID: list[dict[str, Any]] = [
    {"rotors": IN_X},
    {"mixer": "scale"},
    {"rate_delay": 0.001},
    {"motor_lag": "thrust"},
    {"inflow": 0.01},
    SPINNING,
]


@pytest.mark.parametrize("says", SAID)
def test_whoever_says_more_flies_a_detailed_plant(says):
    assert plant_kind_of(drone(**says)) != PLAIN == plant_kind_of(drone())


@pytest.mark.parametrize(
    ("says", "message"),
    [
        ({"rotors": IN_X[:3]}, "there must be 4 to 8, not 3"),
        ({"rotors": (*IN_X[:3], (-LEVER, LEVER, 0.5))}, "spin is 1 or -1, not 0.5"),
        ({"rotors": [(x, y, 1.0) for x, y, _ in IN_X]}, "cannot be asked for one by one"),
        ({"rotors": [(x, 0.0, spin) for x, _, spin in IN_X]}, "on one line"),
        ({"rotors": ring(6), "arm": 0.25}, "arm: the farthest of the rotors is 0.2 m"),
        ({"rotor_inertia": 1e-5}, "rotor_speed: is missing"),
        ({"rate_delay": 9.0}, "less than or equal to 0.05"),
        ({"rate_loop": {"p": (0.1, 0.1, 0.0)}}, "greater than 0"),
        ({"mixer": "mix"}, "clip"),
    ],
)
def test_what_no_vehicle_has_is_refused(says, message):
    with pytest.raises(ValidationError, match=message):
        drone(**says)
