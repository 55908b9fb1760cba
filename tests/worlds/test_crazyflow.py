"""crazyflow flies our vehicles as the equations say, and its own as its description says."""

from __future__ import annotations

import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap import worlds
from hotlap.core.errors import UnknownNameError
from hotlap.core.records import End
from hotlap.files.descriptions import load_quadrotor
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds import crazyflow, rotorpy
from hotlap.worlds.crazyflow import Crazyflow
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.separate import Separate
from hotlap.worlds.simulator import SimulatorError, Start
from worlds.contract import SimulatorContract

needed = pytest.mark.skipif(not crazyflow.installed(), reason="crazyflow is not installed")
LANES = 3
HIGH = np.array([0.0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])
OWN = "cf21B_500"


class Fleet:
    """Crazyflows, one after the other, in one process: compiled once."""

    def __init__(self) -> None:
        self.lanes, self.step, self.scales_thrust = LANES, crazyflow.STEP, False

    def become(self, vehicle: Quadrotor, drone: str) -> None:
        self._now = Crazyflow(vehicle, drone=drone, lanes=LANES)
        self.reset, self.advance, self.close = self._now.reset, self._now.advance, self._now.close
        self.states, self.rotor_thrusts = self._now.states, self._now.rotor_thrusts


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)  # MuJoCo writes a log where it runs
        flying = Separate(Fleet, environment=crazyflow.ENVIRONMENT)
    flying.folder = folder
    yield flying
    flying.close()


@pytest.fixture
def place(fleet):
    def made(vehicle: Quadrotor, state: np.ndarray = HIGH, drone: str = "") -> Separate:
        fleet._ask("become", vehicle, drone)
        for lane in range(LANES):
            fleet.reset(lane, Start(state))
        return fleet

    return made


def advance(simulator: Separate, command: tuple[float, ...], duration: float) -> np.ndarray:
    simulator.advance(np.tile(command, (LANES, 1)), duration)
    return simulator.states()[0]


def moving(*velocity: float) -> np.ndarray:
    state = HIGH.copy()
    state[7:10] = velocity
    return state


@pytest.mark.check
@needed
class TestCrazyflow(SimulatorContract):
    place = 1e-5  # m: it computes in single precision

    def make(self, quadrotor):
        return Separate(Crazyflow, quadrotor, None, "", LANES, environment=crazyflow.ENVIRONMENT)

    def lose(self, simulator):
        simulator._process.kill()


@pytest.mark.check
@needed
class TestVehicles:
    @pytest.mark.parametrize("vehicle", ["airsim", "hummingbird", "cf21b-500"])
    def test_any_vehicle_hovers_where_it_is(self, place, vehicle):
        quadrotor = load_quadrotor(vehicle)
        simulator = place(quadrotor)
        state = advance(simulator, (quadrotor.gravity, 0, 0, 0), 0.5)
        np.testing.assert_allclose(state, HIGH, atol=1e-4)
        np.testing.assert_allclose(simulator.rotor_thrusts(), quadrotor.mass * quadrotor.gravity / 4, rtol=1e-4)

    def test_its_own_drone_hovers_where_it_is(self, place):
        simulator = place(load_quadrotor("cf21b-500"), drone=OWN)
        state = advance(simulator, (9.81, 0, 0, 0), 0.5)
        np.testing.assert_allclose(state[:7], HIGH[:7], atol=1e-2)
        np.testing.assert_allclose(simulator.rotor_thrusts(), 0.0434 * 9.81 / 4, rtol=1e-2)

    @pytest.mark.parametrize("vehicle", ["airsim-122m", "cf21b-500"])
    def test_hard_turns_are_those_of_rotorpy(self, place, vehicle):
        """Two simulators that share no line, and a vehicle without what they have in different forms."""
        if not rotorpy.installed():
            pytest.skip("rotorpy is not installed")
        quadrotor = load_quadrotor(vehicle).model_copy(update={"rotor_drag": 0.0, "body_drag": (0.0, 0.0, 0.0)})
        ours, theirs = place(quadrotor), rotorpy.RotorPy(quadrotor)
        theirs.reset(0, Start(HIGH))
        for k in range(100):
            t = 0.01 * k
            command = 11 + 3 * np.sin(5 * t), 2 * np.sin(9 * t), 1.5 * np.sin(7 * t + 1), 0.8 * np.sin(4 * t)
            state = advance(ours, command, 0.01)
            theirs.advance(np.array([command]), 0.01)
        np.testing.assert_allclose(state, theirs.states()[0], rtol=0, atol=2e-4)
        np.testing.assert_allclose(ours.rotor_thrusts()[0], theirs.rotor_thrusts()[0], rtol=1e-3)

    @pytest.mark.parametrize(
        ("drag", "expected"),
        [
            ({"drag": (0.3, 0.5, 0.0)}, (-0.3 * 8, -0.5 * 6)),
            ({"body_drag": (0.02, 0.03, 0.0)}, (-0.02 * 8 * 8 / 0.716, -0.03 * 6 * 6 / 0.716)),
            ({"rotor_drag": 0.0276}, tuple(-0.0276 * 4 * np.sqrt(0.716 * 9.81 / 4) * v / 0.716 for v in (8, 6))),
        ],
    )
    def test_each_drag_slows_as_it_should(self, place, drag, expected):
        quadrotor = load_quadrotor("hummingbird").model_copy(update={"rotor_drag": 0.0, **drag})
        state = advance(place(quadrotor, moving(8, 6, 0)), (9.81, 0, 0, 0), 0.01)
        np.testing.assert_allclose((state[7:9] - [8, 6]) / 0.01, expected, rtol=2e-2)

    def test_rotors_take_longer_down_than_up(self, place):
        quadrotor = load_quadrotor("hummingbird").model_copy(update={"motor_time": (0.01, 0.04)})
        hover, most = quadrotor.mass * 9.81 / 4, quadrotor.rotor_thrust[1]
        simulator = place(quadrotor)
        advance(simulator, (60.0, 0, 0, 0), 0.01)
        np.testing.assert_allclose(simulator.rotor_thrusts(), (most**0.5 + (hover**0.5 - most**0.5) * np.exp(-1)) ** 2, rtol=2e-3)

    @pytest.mark.parametrize("drone", ["", OWN])
    @pytest.mark.parametrize("axis", [1, 2, 3])
    def test_it_turns_as_it_is_told_and_the_rotors_say_so(self, place, drone, axis):
        quadrotor = load_quadrotor("cf21b-500")
        simulator, command = place(quadrotor, drone=drone), [9.81, 0.0, 0.0, 0.0]
        command[axis] = 1.0
        state = advance(simulator, tuple(command), 0.05)
        assert 0.05 < state[9 + axis] < 2
        torque = quadrotor.torque_matrix @ simulator.rotor_thrusts()[0]
        assert np.argmax(np.abs(torque / quadrotor.inertia_vector)) == axis - 1
        assert torque[axis - 1] > 0

    def test_its_own_drone_turns_as_our_description_says(self, place):
        """To a seventh of what it turns; with the rate loop of the plain description it is several times as far off."""
        there, drones = place(load_quadrotor("cf21b-500"), drone=OWN), [load_quadrotor(f"cf21b-500{end}") for end in ("-crazyflow", "")]
        known, plain = (PlantSimulator(drone, drone, -np.inf) for drone in drones)
        for plant in (known, plain):
            plant.reset(0, Start(HIGH))
        rates = []
        for step in np.repeat(np.random.default_rng(0).uniform(-3, 3, (20, 3)) * [1, 1, 0.5], 5, axis=0):
            for plant in (known, plain):
                plant.advance(np.array([[9.81, *step]]), 0.01)
            rates.append([advance(there, (9.81, *step), 0.01)[10:], known.states()[0, 10:], plain.states()[0, 10:]])
        measured, ours, before = np.moveaxis(np.array(rates), 1, 0)
        missed, missed_before = (np.sqrt(np.mean((x - measured) ** 2, axis=0)) / measured.std(axis=0) for x in (ours, before))
        assert (missed < 0.15).all()
        assert (missed_before > 3 * missed).all()

    def test_a_lane_that_is_placed_leaves_the_others_where_they_are(self, place):
        simulator = place(load_quadrotor("hummingbird"))
        advance(simulator, (12.0, 1.0, 0, 0), 0.1)
        before = simulator.states()
        simulator.reset(1, Start(moving(1, 2, 3)))
        after = simulator.states()
        np.testing.assert_array_equal(after[[0, 2]], before[[0, 2]])
        np.testing.assert_allclose(after[1], moving(1, 2, 3))

    def test_nothing_is_written_where_it_runs(self, place):
        assert not list(place(load_quadrotor("hummingbird")).folder.iterdir())

    @pytest.mark.parametrize("argument", ["", OWN])
    def test_a_race_flown_there_is_finished_in_every_lane(self, argument):
        scenario = make_scenario() if not argument else make_scenario(vehicle=described(), model=described())
        world = worlds.build(f"crazyflow:{argument}" if argument else "crazyflow")
        flights = world.fly(scenario, parameters(20), np.arange(20))
        world.close()
        assert (flights.end == End.FINISHED).all()
        np.testing.assert_allclose(flights.clock_distance, flights.clock_distance[:1].repeat(20, axis=0), atol=1e-3)

    def test_a_drone_that_it_has_not_is_refused(self):
        with pytest.raises(UnknownNameError, match=r"there is no drone of crazyflow named 'cf21b'; available: cf21B_500, "):
            crazyflow.open_simulator(make_scenario(), 0, "cf21b")

    def test_our_description_of_its_drone_is_its_own(self):
        spec = find_spec("crazyflow")
        file = Path(spec.origin).parent / "dynamics" / "first_principles" / "params.toml"
        theirs, ours = tomllib.loads(file.read_text(encoding="utf-8"))[OWN], load_quadrotor("cf21b-500")
        assert ours.mass == pytest.approx(theirs["mass"], rel=1e-3)
        assert ours.inertia == pytest.approx(np.diag(theirs["J"]))
        assert ours.rotor_thrust == pytest.approx((theirs["thrust_min"], theirs["thrust_max"]), rel=1e-4)
        assert ours.arm == pytest.approx(np.sqrt(2) * theirs["L"], rel=1e-3)


def described() -> dict[str, object]:
    """Crazyflow's drone as ours, for the vehicle of the small race."""
    return {key: getattr(load_quadrotor("cf21b-500"), key) for key in Quadrotor.model_fields if key not in {"name", "provenance"}}


def test_without_the_package_it_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "crazyflow", None)
    monkeypatch.setitem(sys.modules, "jax", None)
    monkeypatch.delitem(sys.modules, "hotlap.worlds.crazyflow_vehicle", raising=False)
    with pytest.raises(SimulatorError, match=r"crazyflow is not installed: pip install 'hotlap\[crazyflow\]'"):
        Crazyflow(load_quadrotor("hummingbird"))
