"""Exports that go back to vehicles and their programs: a bag that ROS reads, parameters of PX4, files of agilicious."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from exporters.studies import tune
from flight.scenarios import make_race, make_scenario
from hotlap.core.errors import InputError
from hotlap.exporters import export
from hotlap.exporters.agilicious import quadrotor_yaml
from hotlap.exporters.px4 import allocation, parameters, torque_slopes
from hotlap.exporters.ros2_bag import TOPICS
from hotlap.exporters.ros2_messages import FIELDS, definition_of
from hotlap.files.descriptions import load_quadrotor, load_race
from hotlap.importers import read as read_foreign
from hotlap.logs.readers import read
from hotlap.race.rotors import RotorLayout


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    with tune(tmp_path_factory.mktemp("study")) as opened:
        yield opened


@pytest.fixture(scope="module")
def bag(study, tmp_path_factory):
    (path,) = export(study, "mcap", tmp_path_factory.mktemp("bag") / "flight.mcap")
    return path


def test_a_bag_is_read_back_as_the_flight_that_was_flown(study, bag):
    scenario, log = study.configuration.scenario, read(bag)
    position = log.signals["position"]
    assert position.times[0] == 0
    assert np.diff(position.times) == pytest.approx(scenario.race.controller.period)
    near = np.linalg.norm(position.values - scenario.reference.position_at(position.times), axis=1)
    assert near.max() < 1.0
    slopes = np.gradient(position.values, position.times, axis=0)
    np.testing.assert_allclose(log.signals["velocity"].values[5:-5], slopes[5:-5], atol=0.2)
    assert set(log.signals) == {"position", "velocity", "attitude", "rates", "rate_command", "thrust_command"}
    assert not log.notes[-1].startswith("the file is cut")


def test_a_bag_brings_the_definition_of_every_message(bag):
    with bag.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        decoded = {channel.topic: message for _, channel, _, message in reader.iter_decoded_messages()}
        summary = reader.get_summary()
    assert {schema.name for schema in summary.schemas.values()} == {kind.replace("/", "/msg/") for kind in TOPICS.values()}
    assert set(decoded) == set(TOPICS)
    assert len(decoded["/gates"].poses) == 5
    path = decoded["/reference"].poses
    assert path[0].header.frame_id == decoded["/odometry"].header.frame_id
    assert path[-1].pose.position.x != path[0].pose.position.x


@pytest.mark.check
def test_the_definitions_are_those_of_ros_2(bag):
    humble, brought = get_typestore(Stores.ROS2_HUMBLE), {}
    with bag.open("rb") as file:
        reader = make_reader(file)
        for schema, _, message in reader.iter_messages():
            brought |= get_types_from_msg(schema.data.decode(), schema.name)
            if schema.name in humble.fielddefs:
                read_back = humble.deserialize_cdr(message.data, schema.name)
                assert read_back.header.frame_id == "map"
    known = set(brought) & set(humble.fielddefs)
    assert len(known) == len(FIELDS) - 1  # mavros_msgs is not part of ROS 2
    assert all(brought[kind][1] == humble.fielddefs[kind][1] for kind in known)


@pytest.mark.parametrize("kind", FIELDS)
def test_a_definition_has_all_that_it_is_made_of_once(kind):
    text = definition_of(kind)
    named = [line.removeprefix("MSG: ") for line in text.splitlines() if line.startswith("MSG: ")]
    assert len(named) == len(set(named))
    used = {word.removesuffix("[]") for line in text.splitlines() for word in line.split()[:1] if "/" in word}
    assert used == set(named)


def test_parameters_of_px4_give_the_gain_of_the_vehicle(study, tmp_path):
    (path,) = export(study, "px4", tmp_path / "mine.params")
    lines = [line.split("\t") for line in path.read_text().splitlines() if not line.startswith("#")]
    values = {name: float(value) for _, _, name, value, kind in lines if kind == "9"}
    vehicle = study.configuration.scenario.race.vehicle
    for a, axis in enumerate(("ROLL", "PITCH", "YAW")):
        motors = allocation(vehicle)[:, a] * values[f"MC_{axis}RATE_P"]  # of an error of 1 rad/s
        torque = vehicle.torque_matrix @ (motors * vehicle.rotor_thrust[1])
        assert torque[a] / vehicle.inertia[a] == pytest.approx(vehicle.hover_rate_gain[a], rel=1e-5)
        assert np.abs(np.delete(torque, a)).max() < 1e-9
    assert values["MPC_THR_HOVER"] == pytest.approx(1 / vehicle.thrust_to_weight, rel=1e-6)
    assert "What they do not say: motor order" in path.read_text()


def test_motors_of_an_x_get_what_px4_gives_them():
    mix = allocation(make_race({"layout": RotorLayout.X}).vehicle)
    np.testing.assert_allclose(np.abs(mix[:, :2]), np.sqrt(0.5))
    np.testing.assert_allclose(np.abs(mix[:, 2]), 1.0)
    assert (torque_slopes(make_race().vehicle) > 0).all()


def test_a_rate_loop_with_three_parts_keeps_their_ratio():
    race = load_race("circle-34")
    scenario = make_scenario()
    loop = {"p": (0.25, 0.2, 0.1), "i": (0.5, 0.4, 0.1), "d": (0.01, 0.01, 0.0)}
    vehicle = type(race.vehicle).model_validate({**scenario.race.vehicle.model_dump(), "rate_loop": loop})
    changed = scenario.race.model_copy(update={"vehicle": vehicle})
    values = parameters(type(scenario)(changed, scenario.reference, scenario.segments))
    assert values["MC_ROLLRATE_I"] / values["MC_ROLLRATE_P"] == pytest.approx(2.0)
    assert values["MC_PITCHRATE_D"] / values["MC_PITCHRATE_P"] == pytest.approx(0.05)
    assert "MC_ROLLRATE_I" not in parameters(scenario)


def test_agilicious_gets_vehicle_and_reference(study, tmp_path):
    yaml, csv = export(study, "agilicious", tmp_path / "mine.yaml")
    scenario = study.configuration.scenario
    mine, theirs = scenario.race.vehicle, load_imported(yaml, tmp_path)
    assert theirs.mass == mine.mass
    assert theirs.inertia == mine.inertia
    assert theirs.torque_ratio == mine.torque_ratio
    assert theirs.rotor_thrust == pytest.approx(mine.rotor_thrust)
    assert theirs.rate_limit == mine.rate_limit
    np.testing.assert_allclose(sorted(theirs.rotor_positions.tolist()), sorted(mine.rotor_positions.tolist()), atol=1e-12)
    rows = np.genfromtxt(csv, delimiter=",", names=True)
    np.testing.assert_array_equal(rows["p_x"][: scenario.reference.planned_rows], scenario.reference.position[: len(rows), 0])


def load_imported(path, folder):
    """The quadrotor that hotlap reads of a file of agilicious."""
    imported = read_foreign(path)
    (folder / "imported.toml").write_text(imported.text)
    return load_quadrotor(folder / "imported.toml")


def test_agilicious_has_four_rotors_one_in_each_quarter():
    six = [(0.17 * math.cos(k * math.pi / 3), 0.17 * math.sin(k * math.pi / 3), (-1) ** k) for k in range(6)]
    vehicle = type(make_race().vehicle).model_validate({**make_race().vehicle.model_dump(), "rotors": six})
    with pytest.raises(InputError, match="agilicious takes four rotors"):
        quadrotor_yaml(vehicle, "race", "reference.csv")
    crossed = quadrotor_yaml(make_race({"layout": RotorLayout.X}).vehicle, "race", "reference.csv")
    assert "tbm_fr: [0.12" in crossed
