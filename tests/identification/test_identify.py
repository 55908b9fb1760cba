"""Identification finds the numbers of a vehicle that is known, says how sure it is, and what a log cannot tell."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.dynamics.mixers import Mixer
from hotlap.files.descriptions import load_quadrotor
from hotlap.identification.identify import identify
from hotlap.identification.quadrotor_file import quadrotor_of, text_of
from hotlap.identification.rehearsal import rehearse
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.report.identification_chart import identification
from hotlap.worlds.betaflight.gains import rate_loop_of
from hotlap.worlds.plant_simulator import PlantSimulator
from identification.flights import BASE, TOLD, WITHIN, drawn, errors

SEED = 7
PID = BASE.model_copy(update={"mixer": Mixer.BETAFLIGHT, "rate_loop": rate_loop_of(BASE)})


@pytest.fixture(scope="module")
def truth():
    return drawn(SEED)


@pytest.fixture(scope="module")
def found(truth):
    return identify([truth.fly(SEED)], BASE, thrust_known=True)


@pytest.fixture(scope="module")
def by_accelerometer(truth):
    """Of half a minute without straights, with throttles whose thrust is not known and a battery that sags."""
    log = truth.fly(SEED + 1, accelerometer=True, seconds=30.0)
    signals = {name: signal for name, signal in log.signals.items() if name != "velocity"}
    thrust = signals["thrust_command"]
    voltage = np.linspace(16.8, 14.0, len(thrust.times))[:, None]
    signals["battery"] = Signal(thrust.times, voltage)
    signals["thrust_command"] = Signal(thrust.times, thrust.values * (voltage[0] / voltage) ** 2)
    return identify([replace(log, signals=signals, facts={})], BASE)


def test_a_minute_tells_all_within_five_per_cent(found, truth):
    off = errors(found, truth)
    assert set(TOLD) | {"drag x", "drag y", "drag z"} == set(off)
    assert {name: off[name] for name in TOLD if off[name] > WITHIN} == {}
    assert found.untold == ()


def test_intervals_are_narrow_and_hold_what_they_are_about(found):
    for one in found.estimates:
        assert one.low < one.value < one.high
        if one.name in TOLD:
            assert one.high - one.low < 2 * WITHIN * one.value


def test_what_was_not_fitted_is_predicted_down_to_the_noise(found):
    for one in found.predictions:
        noise = 0.05 * (1.5 if one.channel == "velocity" else 1.1)
        assert one.error < noise
        assert one.former_error > one.error


def test_an_accelerometer_and_throttles_tell_the_same(by_accelerometer, truth):
    known = by_accelerometer.thrust_map
    full = BASE.max_acceleration * BASE.mass / truth.vehicle.mass
    assert known.hover == pytest.approx(BASE.gravity / full, rel=0.02)
    assert abs(known.curvature) < 0.15
    assert known.power == pytest.approx(2.0, abs=0.2)
    assert known.voltage == pytest.approx(16.75, abs=0.1)
    off = errors(by_accelerometer, truth)
    assert {name: off[name] for name in TOLD if name in off and off[name] > WITHIN} == {}


def test_drag_needs_a_velocity(by_accelerometer):
    assert {one.name: one.reason for one in by_accelerometer.untold}["drag"] == "no velocity and attitude are logged"


def test_hover_alone_tells_no_gains_and_keeps_those_of_the_base(truth):
    log = truth.fly(1, pushes=False, seconds=8.0)
    steady = Signal(log.signals["rates"].times, np.full((len(log.signals["rates"].times), 1), 15.0))
    quiet = identify([replace(log, signals={**log.signals, "battery": steady})], BASE)
    untold = {one.name: one for one in quiet.untold}
    assert untold["power of voltage"].reason == "the battery was from 15.00 to 15.00 V only"
    assert "battery is nearly empty" in untold["power of voltage"].manoeuvre
    assert {"rate gain yaw", "drag x", "drag y"} <= set(untold)
    assert untold["rate gain yaw"].manoeuvre.startswith("yaw doublets")
    assert quadrotor_of(quiet, "mine").rate_gain[2] == BASE.rate_gain[2]
    assert "rate gain yaw: yaw was hardly asked to turn" in text_of(quiet, "five-inch")


@pytest.mark.check
def test_filters_of_a_firmware_are_not_taken_for_lag_of_the_motors():
    """The rate loop of the vehicle answers 7.5 ms later than that of its base."""
    base = PID.model_copy(update={"delay": 0.0})
    filtered = PID.model_copy(update={"rate_delay": 0.0075, "motor_time": (0.03, 0.04)})
    found = identify([rehearse(PlantSimulator(filtered, PID), PID, seed=2, delay=0.03)], base)
    numbers = {one.name: one.value for one in found.estimates}
    assert numbers["motor lag up"] == pytest.approx(0.03, rel=0.1)
    assert numbers["motor lag down"] == pytest.approx(0.04, rel=0.1)


@pytest.mark.check
def test_a_rate_loop_that_is_known_stays_as_it_is():
    vehicle = PID.model_copy(update={"rotor_thrust": (0.1, 9.0)})
    found = identify([rehearse(PlantSimulator(vehicle, PID), PID, seed=3, delay=0.02)], PID, loop_known=True)
    assert not [one.name for one in found.estimates if one.name.startswith(("rate", "factor"))]
    mine = quadrotor_of(found, "mine")
    assert mine.rate_loop == PID.rate_loop
    assert found.known == "mass and rate loop"


def test_the_file_is_the_quadrotor(found, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(text_of(found, "five-inch"), encoding="utf-8")
    read, told = load_quadrotor(path), quadrotor_of(found, "mine")
    assert read.model_dump(exclude={"name", "provenance"}) == told.model_dump(exclude={"name", "provenance"})
    assert read.mass == pytest.approx(found.estimates[0].value, rel=1e-5)
    assert tomllib.loads(path.read_text())["base"] == "five-inch"


def test_the_chart_shows_every_channel(found):
    figure = identification(found)
    assert len(figure.axes) == 6
    assert all(len(axes.lines) > 3 * 14 for axes in figure.axes)


def a_log(**changed) -> FlightLog:
    times = np.linspace(0.0, 9.99, 1000)
    signals = {name: Signal(times, np.zeros((1000, 3))) for name in ("rates", "rate_command")}
    signals["thrust_command"] = Signal(times, np.full((1000, 1), 0.3))
    signals |= changed
    return FlightLog("flight", "made up", {name: signal for name, signal in signals.items() if signal is not None})


def constant(value: float, columns: int, every: float = 0.01, seconds: float = 10.0) -> Signal:
    times = np.arange(0.0, seconds, every)
    return Signal(times, np.full((len(times), columns), value))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"rates": None}, "rates: is missing: no body rates: a gyroscope's log is needed"),
        ({"rate_command": None}, "rate_command: is missing: no commanded body rates"),
        ({"rates": constant(0.0, 2)}, "rates: has 2 axes, not 3"),
        ({"rates": constant(0.0, 3, 0.1)}, "rates: has 10 samples a second; at least 20 are needed"),
        ({"rates": constant(200.0, 3)}, "rates: is up to 200 rad/s: is it in deg/s?"),
        ({"rates": constant(np.nan, 3)}, "rates: has values that are not finite, or times that do not increase"),
        ({"rates": constant(0.0, 3, 0.01, 3.0)}, "3.0 s with commands and rates; at least 5 s are needed"),
        ({"thrust_command": constant(1500.0, 1)}, "thrust_command: is from 1.5e+03 to 1.5e+03, and must be from 0 to 1"),
        (
            {"acceleration": constant(0.5, 3)},
            "acceleration: is 0.866 m/s^2 most of the time, and hovering is 9.81: is it in g, or without gravity?",
        ),
    ],
)
def test_a_log_that_cannot_be_used_is_told_in_one_line(changed, message):
    with pytest.raises(InputError) as caught:
        identify([a_log(**changed)], BASE)
    assert str(caught.value).startswith(f"flight: {message}")
