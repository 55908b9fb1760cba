"""The real firmware in lockstep; these build the shim, and need the package `betaflight`, which builds the firmware."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap import worlds
from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_quadrotor
from hotlap.race.quadrotor import RotorLayout
from hotlap.system.sealed import CacheWarning
from hotlap.worlds.betaflight import built, console
from hotlap.worlds.betaflight.console import configured
from hotlap.worlds.betaflight.gains import as_flown
from hotlap.worlds.betaflight.link import BOOT, Link
from hotlap.worlds.betaflight.settings import Line, configuration, read_lines
from hotlap.worlds.betaflight.simulator import Betaflight
from hotlap.worlds.betaflight.sticks import resting
from hotlap.worlds.identification import identify_rate_loop
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import SimulatorError, Start
from worlds.contract import PLAIN, SimulatorContract

try:
    built.firmware()
    MISSING = ""
except SimulatorError as error:
    MISSING = str(error)
pytestmark = [pytest.mark.check, pytest.mark.skipif(bool(MISSING), reason=MISSING or "the firmware is there")]

STATE = np.array([1.0, -2.0, 30.0, 1.0, *np.zeros(9)])
DIFF = """# diff all
batch start
defaults nosave
resource BEEPER 1 C13
feature RX_SERIAL
serial 1 64 115200 57600 0 115200
aux 1 1 1 900 2100 0 0
set osd_vbat_pos = 234
set dshot_bidir = ON
set motor_pwm_protocol = DSHOT600
set align_board_yaw = 90
set gyro_1_sensor_align = CW90
profile 0
set p_roll = 50
rateprofile 0
set rates_type = BETAFLIGHT
batch end
save
"""


class TestX(SimulatorContract):
    """It repeats bit for bit."""

    same = 0.0

    def make(self, quadrotor):
        return Betaflight(quadrotor)

    def lose(self, simulator):
        os.kill(simulator._flying.answer.process, signal.SIGKILL)


class TestPlus(TestX):
    quadrotor = PLAIN.model_copy(update={"layout": RotorLayout.PLUS})


@pytest.fixture
def airborne():
    """Opens simulators, and closes them."""
    opened = []

    def fly(name="five-inch", own=(), **options):
        opened.append(Betaflight(load_quadrotor(name), own, **options))
        opened[-1].reset(0, Start(STATE))
        return opened[-1]

    yield fly
    for simulator in opened:
        simulator.close()


def manoeuvre(simulator, start=STATE):
    """States after each of forty random commands."""
    random = np.random.default_rng(3)
    simulator.reset(0, Start(start, 1.02))
    states = []
    for _ in range(40):
        simulator.advance(np.array([[random.uniform(2, 20), *random.uniform(-6, 6, 3)]]), 0.01)
        states.append(simulator.states()[0])
    return np.array(states)


def test_flights_repeat_bit_for_bit_whatever_was_flown_before(airborne):
    first = airborne()
    once = manoeuvre(first)
    np.testing.assert_array_equal(once, manoeuvre(first))
    first.reset(0, Start(STATE))
    first.advance(np.array([[20.0, 9.0, -9.0, 3.0]]), 0.5)
    np.testing.assert_array_equal(once, manoeuvre(first))
    np.testing.assert_array_equal(once, manoeuvre(airborne()))


def test_instances_side_by_side_fly_as_each_does_alone(airborne):
    alone = manoeuvre(airborne())
    simulators = [airborne() for _ in range(3)]
    flown = {}
    threads = [threading.Thread(target=lambda k=k: flown.update({k: manoeuvre(simulators[k])})) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    for states in flown.values():
        np.testing.assert_array_equal(states, alone)
    assert len(flown) == 3


@pytest.mark.parametrize("name", ["hummingbird", "airsim", "five-inch", "split-s-racer"])
def test_it_hovers_and_follows_rates_on_every_axis(airborne, name):
    simulator, gravity = airborne(name), load_quadrotor(name).gravity
    simulator.advance(np.array([[gravity, 0.0, 0.0, 0.0]]), 1.0)
    np.testing.assert_allclose(simulator.states()[0, :3], STATE[:3], atol=0.05)
    np.testing.assert_allclose(simulator.states()[0, 3:7], [1, 0, 0, 0], atol=1e-3)
    for axis in range(3):
        simulator.reset(0, Start(STATE))
        command = np.array([[gravity, 0.0, 0.0, 0.0]])
        command[0, 1 + axis] = 1.0
        simulator.advance(command, 0.4 if axis < 2 else 1.0)
        rates = simulator.states()[0, 10:]
        assert rates[axis] == pytest.approx(1.0, abs=0.35)
        assert np.abs(np.delete(rates, axis)).max() < 0.15


def test_the_rate_loop_is_the_firmwares(airborne):
    """Higher gains, faster; and the user's come through."""
    rates = []
    for gain in (25, 90):
        simulator = airborne(own=(Line(f"set p_roll = {gain}"),))
        simulator.advance(np.array([[9.81, 2.0, 0.0, 0.0]]), 0.02)
        rates.append(simulator.states()[0, 10])
    assert 0 < rates[0] < 0.8 * rates[1]


def test_thrust_and_its_factor_are_the_vehicles(airborne):
    simulator = airborne("airsim")
    climbs = []
    for factor in (1.0, 1.1):
        simulator.reset(0, Start(STATE, factor))
        simulator.advance(np.array([[13.0, 0.0, 0.0, 0.0]]), 0.3)
        climbs.append(simulator.states()[0, 9])
    assert climbs[0] == pytest.approx((13.0 - 9.81) * 0.3, rel=0.1)
    assert climbs[1] - climbs[0] == pytest.approx(1.3 * 0.3, rel=0.1)
    np.testing.assert_allclose(simulator.rotor_thrusts().sum(), 13.0, rtol=0.02)


def test_a_drone_on_the_ground_stays_there_until_it_takes_off(airborne):
    simulator, ground = airborne(floor=0.0), STATE.copy()
    ground[2] = 0.0
    simulator.reset(0, Start(ground))
    simulator.advance(np.array([[2.0, 0.0, 0.0, 0.0]]), 0.2)
    assert simulator.states()[0, 2] == 0.0
    simulator.advance(np.array([[15.0, 0.0, 0.0, 0.0]]), 0.3)
    assert simulator.states()[0, 2] > 0.1
    simulator.advance(np.array([[0.1, 0.0, 0.0, 0.0]]), 1.0)
    assert simulator.states()[0, 2] < 0.0


def test_a_diff_all_of_a_real_board_flies(airborne, tmp_path):
    path = tmp_path / "my-diff.txt"
    path.write_text(DIFF)
    simulator = airborne(own=read_lines(path))
    simulator.advance(np.array([[9.81, 1.0, 0.0, 0.0]]), 0.3)
    np.testing.assert_allclose(simulator.states()[0, 10:], [1.0, 0.0, 0.0], atol=0.15)


def test_a_line_that_the_firmware_refuses_is_named(tmp_path):
    path = tmp_path / "my-diff.txt"
    path.write_text("set p_roll = 45\nset p_rol = 45\n\nset osd_vbat_pos = 1\nset p_pitch = 999\nwrong\n")
    with pytest.raises(InputError, match=r"my-diff\.txt: line 2: Betaflight refuses 'set p_rol = 45': INVALID NAME.*; also lines 5, 6$"):
        Betaflight(load_quadrotor("five-inch"), read_lines(path))


def test_a_configuration_is_kept_for_the_next_time(monkeypatch):
    vehicle = load_quadrotor("five-inch")
    lines = configuration(vehicle.layout, 620)
    eeprom = configured(lines)
    monkeypatch.setattr(console, "launch", lambda *_, **__: pytest.fail("configured anew"))
    assert configured(lines) == eeprom


def test_a_configuration_that_was_damaged_is_made_anew(monkeypatch, tmp_path):
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path))
    vehicle = load_quadrotor("five-inch")
    lines = configuration(vehicle.layout, 620)
    eeprom = configured(lines)
    (kept,) = (tmp_path / "betaflight").glob("*.bin")
    kept.write_bytes(kept.read_bytes()[:-9])
    with pytest.warns(CacheWarning, match="is damaged"):
        assert configured(lines) == eeprom


def test_a_clock_that_was_damaged_is_built_anew(monkeypatch, tmp_path):
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path))
    built.shim.cache_clear()
    whole = built.shim().read_bytes()
    built.shim().write_bytes(whole[:3000] + b"?" + whole[3001:])
    built.shim.cache_clear()
    with pytest.warns(CacheWarning, match="is damaged"):
        assert built.shim().stat().st_mode & 0o777 == 0o600
    built.shim.cache_clear()


def test_a_killed_firmware_is_one_line(airborne):
    simulator = airborne()
    os.kill(simulator._flying.answer.process, signal.SIGKILL)
    with pytest.raises(SimulatorError, match=r"^Betaflight has ended[^\n]*$"):
        simulator.advance(np.array([[9.81, 0.0, 0.0, 0.0]]), 0.5)
    os.kill(simulator._armed.answer.process, signal.SIGKILL)
    with pytest.raises(SimulatorError, match=r"^Betaflight has ended[^\n]*$"):
        simulator.reset(0, Start(STATE))


def test_a_silent_firmware_is_given_up_and_ended(airborne):
    simulator = airborne(patience=1.0)
    process = simulator._flying.answer.process
    os.kill(process, signal.SIGSTOP)
    began = time.monotonic()
    with pytest.raises(SimulatorError, match=r"^Betaflight has not answered for 1 s$"):
        simulator.advance(np.array([[9.81, 0.0, 0.0, 0.0]]), 0.5)
    assert time.monotonic() - began < 10
    simulator.close()
    assert_gone([process])


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("os.write(orders, b'garbage'), os.read(orders, 1)", "Betaflight answers what nobody understands"),
        ("os.write(orders, bytes(48)), os.read(orders, 1)", "Betaflight answers what nobody understands"),
        (
            "os.write(orders, struct.pack('<4Q4f', 3, 0, 0, 0, *4 * [float('nan')])), os.read(orders, 1)",
            r"Betaflight sends \[nan.* to its motors",
        ),
        ("os.read(orders, 1)", "Betaflight has not answered for 2 s"),
        ("os._exit(7)", "Betaflight has ended with exit status 7"),
    ],
)
def test_what_is_no_firmware_is_one_line(tmp_path, script, says):
    program = tmp_path / "firmware"
    program.write_text(f"#!{sys.executable} -SE\nimport os, struct\norders = int(os.environ['LOCKSTEP_ORDERS'])\n{script}\n")
    program.chmod(0o755)
    with pytest.raises(SimulatorError, match=f"^{says}$"):
        Link.start(b"", program=program, patience=2.0)


def test_a_program_that_cannot_be_started_is_one_line(tmp_path):
    with pytest.raises(SimulatorError, match=r"cannot be started: No such file"):
        Link.start(b"", program=tmp_path / "none")


def test_it_listens_on_no_port(airborne):
    simulator = airborne()
    for link in (simulator._armed, simulator._flying):
        process = link.answer.process
        mine = {str(entry.readlink()).removeprefix("socket:[").rstrip("]") for entry in Path(f"/proc/{process}/fd").iterdir()}
        for table in ("tcp", "tcp6", "udp", "udp6"):
            rows = [line.split() for line in Path(f"/proc/{process}/net/{table}").read_text().splitlines()[1:]]
            assert not [row for row in rows if row[9] in mine]


def test_it_ends_with_the_process_that_opened_it():
    code = """
import os, signal, sys
from hotlap.files.descriptions import load_quadrotor
from hotlap.worlds.betaflight.simulator import Betaflight
from hotlap.worlds.simulator import Start
import numpy as np
simulator = Betaflight(load_quadrotor("five-inch"))
simulator.reset(0, Start(np.array([0.0, 0.0, 9.0, 1.0, *np.zeros(9)])))
print(simulator._armed.answer.process, simulator._flying.answer.process, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert_gone([int(process) for process in done.stdout.split()])


def test_closing_ends_all_processes_and_may_happen_twice(airborne):
    simulator = airborne()
    processes = [simulator._armed.answer.process, simulator._flying.answer.process]
    simulator.close()
    simulator.close()
    assert_gone(processes)


def test_what_comes_back_in_time_must_be_of_that_time():
    vehicle = load_quadrotor("five-inch")
    link = Link.start(configured(configuration(vehicle.layout, 620)))
    try:
        still = np.zeros(3), np.array([0.0, 0.0, 9.81]), np.array([1.0, 0.0, 0.0, 0.0])
        assert link.run(BOOT + 1_000_000, resting(armed=False), *still).now >= BOOT + 1_000_000
        with pytest.raises(SimulatorError):  # a firmware does not go back in time
            link.run(BOOT, resting(armed=False), *still)
    finally:
        link.close()


def test_a_race_is_flown_alike_by_one_and_by_two_of_them():
    """Dead time, noise and all."""
    scenario = make_scenario(vehicle={"delay": 0.02}, noise={"position": 0.05, "rates": 0.1, "thrust": 0.02, "thrust_bias": 0.02})
    flown = []
    for instances in (1, 2):
        world = worlds.build("betaflight", instances)
        flown.append(world.fly(scenario, parameters(3), np.array([4, 5, 6]), log=[2]))
        world.close()
    assert (flown[0].gates_passed > 2).all()
    assert len(set(flown[0].mean_error.tolist())) == 3
    np.testing.assert_array_equal(flown[0].clock_distance, flown[1].clock_distance)
    np.testing.assert_array_equal(flown[0].logs[2].states, flown[1].logs[2].states)


def test_a_flight_whose_firmware_ends_is_lost_and_the_next_one_flies(monkeypatch):
    scenario, begun = make_scenario(noise={"position": 0.05}), []
    reset = Betaflight.reset

    def reset_and_kill(self, lane, start):
        reset(self, lane, start)
        begun.append(self)
        if len(begun) == 2:
            process = self._flying.answer.process
            threading.Timer(0.1, lambda: os.kill(process, signal.SIGKILL)).start()
            time.sleep(0.2)

    monkeypatch.setattr(Betaflight, "reset", reset_and_kill)
    world, notes = worlds.build("betaflight"), []
    world.note = notes.append
    flights = world.fly(scenario, parameters(3), np.array([4, 5, 6]))
    world.close()
    assert len(notes) == 1
    assert notes[0].startswith("betaflight: Betaflight has ended")
    assert (flights.gates_passed > 2).sum() >= 2
    assert begun[0] is not begun[-1]


def test_the_fitted_rate_loop_is_nearer_to_it_than_the_files(airborne):
    vehicle = load_quadrotor("five-inch")
    fit = identify_rate_loop(airborne(), vehicle, seconds=2.0)
    assert (fit.error < fit.former_error).all()
    assert fit.rate_gain[0] > 1.5 * vehicle.rate_gain[0]
    assert fit.lines(vehicle).startswith("rate_gain = [")


def assert_gone(processes):
    """Processes end within seconds."""
    for process in processes:
        for _ in range(100):
            with suppress(ProcessLookupError, FileNotFoundError):
                os.kill(process, 0)
                if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
                    time.sleep(0.05)
                    continue
            break
        else:
            pytest.fail(f"process {process} is still there")


@pytest.mark.parametrize("name", ["hummingbird", "five-inch"])
def test_a_drone_as_flown_turns_at_home_as_it_does_with_the_firmware(name):
    drone = load_quadrotor(name)
    steps = np.random.default_rng(0).uniform(-3, 3, (40, 3)) * [1, 1, 0.4]
    simulator = Betaflight(drone)
    try:
        there = rates_of(simulator, drone, steps)
    finally:
        simulator.close()
    as_written, known = (rates_of(PlantSimulator(vehicle, vehicle, -np.inf), drone, steps) for vehicle in (drone, as_flown(drone)))
    missed = [np.sqrt(np.mean((rates - there) ** 2, axis=0)) / there.std(axis=0) for rates in (as_written, known)]
    assert (missed[1][:2] < 0.8 * missed[0][:2]).all()  # roll and pitch
    assert (missed[1] < 0.35).all()


def rates_of(simulator, drone, steps):
    """Body rates every 10 ms under steps of 50 ms, from hover."""
    simulator.reset(0, Start(STATE))
    rates = []
    for step in np.repeat(steps, 5, axis=0):
        simulator.advance(np.array([[drone.gravity, *step]]), 0.01)
        rates.append(simulator.states()[0, 10:])
    return np.array(rates)


def test_the_twin_at_home_answers_a_step_of_yaw_as_the_firmware_does():
    """To a hundredth of a step and to its end, integral included."""
    twin = as_flown(load_quadrotor("five-inch"))
    rows = []
    firmware = Betaflight(twin)
    for simulator in (firmware, PlantSimulator(twin, twin)):
        simulator.reset(0, Start(STATE))
        hover, turn = (np.tile([9.81, 0.0, 0.0, rate], (simulator.lanes, 1)) for rate in (0.0, 1.0))
        simulator.advance(hover, 0.6)
        for _ in range(50):
            simulator.advance(turn, 0.01)
            rows.append(simulator.states()[0, 12])
    firmware.close()
    there, here = np.array(rows).reshape(2, -1)
    assert np.sqrt(np.mean((there - here) ** 2)) < 0.03


def test_thrust_is_what_the_pilot_takes_the_vehicle_for():
    believed = load_quadrotor("five-inch")
    low, high = believed.rotor_thrust
    weak = believed.model_copy(update={"rotor_thrust": (low, 0.85 * high)})
    simulator = Betaflight(weak, known_as=believed)
    simulator.reset(0, Start(STATE))
    simulator.advance(np.array([[believed.gravity, 0.0, 0.0, 0.0]]), 0.4)
    assert simulator.rotor_thrusts().sum() / (weak.mass * weak.gravity) == pytest.approx(0.85, rel=0.02)
    simulator.close()
