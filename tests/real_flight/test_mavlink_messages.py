"""Frames, clocks, whole states and addresses of MAVLink."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.core.errors import InputError
from hotlap.real_flight import open_link
from hotlap.real_flight.clocks import FollowedClock, OffsetClock
from hotlap.real_flight.mavlink.address import address_of
from hotlap.real_flight.mavlink.frames import BODY_FRD, LOCAL_FRD, LOCAL_NED, odometry_of, rates_told, state_of_odometry
from hotlap.real_flight.mavlink.states import States
from hotlap.reference.attitude import thrust_axis

NUMBERS = st.floats(-9.0, 9.0)


class Message(SimpleNamespace):
    """A message of MAVLink, as far as it is read."""

    def get_type(self):
        return self.kind


def odometry(state, time, **changed):
    fields = {**odometry_of(state), "time_usec": round(1e6 * time), "reset_counter": 0, "quality": 0, "kind": "ODOMETRY", **changed}
    return Message(**fields)


@given(values=st.lists(NUMBERS, min_size=13, max_size=13))
def test_a_state_comes_back_as_it_was(values):
    state = np.array(values)
    state[3:7] += [10.0, 0.0, 0.0, 0.0]
    state[3:7] /= np.linalg.norm(state[3:7])
    assert state_of_odometry(Message(**odometry_of(state))) == pytest.approx(state, abs=1e-9)


def test_north_is_x_west_is_y_up_is_z_and_so_in_the_body():
    half = np.sqrt(0.5)
    message = Message(
        frame_id=LOCAL_NED, child_frame_id=LOCAL_NED, x=1.0, y=2.0, z=-3.0, q=[half, 0.0, half, 0.0], vx=4.0, vy=5.0, vz=6.0,
        rollspeed=0.1, pitchspeed=0.2, yawspeed=0.3,
    )  # fmt: skip
    state = state_of_odometry(message)
    assert state[:3].tolist() == [1, -2, 3]
    assert state[7:10].tolist() == [4, -5, -6]
    assert state[10:].tolist() == pytest.approx([0.1, -0.2, -0.3])
    assert thrust_axis(state[3:7]) == pytest.approx([-1, 0, 0])  # the nose points up, so what was up points south
    assert rates_told(np.array([0.1, 0.2, 0.3])) == [0.1, -0.2, -0.3]


def test_velocity_in_the_body_is_turned_into_the_world():
    half = np.sqrt(0.5)
    east = Message(
        frame_id=LOCAL_NED, child_frame_id=BODY_FRD, x=0.0, y=0.0, z=0.0, q=[half, 0.0, 0.0, half], vx=3.0, vy=0.0, vz=0.0,
        rollspeed=0.0, pitchspeed=0.0, yawspeed=0.0,
    )  # fmt: skip
    assert state_of_odometry(east)[7:10] == pytest.approx([0, -3, 0], abs=1e-12)
    for frames in ({"frame_id": 8}, {"child_frame_id": LOCAL_FRD}, {"child_frame_id": 8}):
        assert state_of_odometry(Message(**{**vars(east), **frames})) is None
    assert state_of_odometry(Message(**{**vars(east), "child_frame_id": LOCAL_NED}))[7:10].tolist() == [3, 0, 0]


def position(time, x):
    return Message(kind="LOCAL_POSITION_NED", time_boot_ms=round(1e3 * time), x=x, y=0.0, z=-1.0, vx=1.0, vy=0.0, vz=0.0)


def attitude(time, yaw, kind="ATTITUDE_QUATERNION", rate=0.0):
    turning = {"rollspeed": 0.0, "pitchspeed": 0.0, "yawspeed": rate}
    if kind == "ATTITUDE":
        return Message(kind=kind, time_boot_ms=round(1e3 * time), roll=0.0, pitch=0.0, yaw=yaw, **turning)
    return Message(kind=kind, time_boot_ms=round(1e3 * time), q1=np.cos(yaw / 2), q2=0.0, q3=0.0, q4=np.sin(yaw / 2), **turning)


@pytest.mark.parametrize("kind", ["ATTITUDE_QUATERNION", "ATTITUDE"])
def test_a_position_and_an_attitude_make_a_state_whichever_comes_first(kind):
    states = States()
    assert states.hear(position(1.0, 5.0)) is None
    stamp, state = states.hear(attitude(1.0, 0.4, kind))
    assert (stamp, state[0], state[2]) == (1.0, 5.0, 1.0)
    assert state[3:7] == pytest.approx([np.cos(0.2), 0, 0, -np.sin(0.2)])
    assert states.hear(attitude(1.02, 0.4, kind)) is None
    stamp, state = states.hear(position(1.02, 6.0))
    assert (stamp, state[0]) == (1.02, 6.0)


def test_an_attitude_is_turned_on_to_the_time_of_the_position():
    states = States()
    states.hear(attitude(1.0, 0.0, rate=1.0))
    states.hear(position(1.01, 5.0))
    _, state = states.hear(attitude(1.02, 0.02, rate=1.0))
    assert state[3:7] == pytest.approx([np.cos(0.005), 0, 0, -np.sin(0.005)], abs=1e-6)


def test_an_attitude_that_is_too_old_makes_no_state():
    states = States()
    states.hear(attitude(1.0, 0.0))
    states.hear(position(1.2, 5.0))
    assert states.hear(position(1.22, 5.0)) is None


def test_odometry_counts_where_it_speaks_and_what_is_older_never():
    states, state = States(), np.concatenate([np.zeros(3), [1.0], np.zeros(9)])
    assert states.hear(odometry(state, 2.0, reset_counter=3))[0] == 2.0
    assert states.resets == 3
    assert states.hear(odometry(state, 1.99)) is None
    assert states.hear(odometry(state, 2.0)) is None
    states.hear(attitude(2.01, 0.0))
    assert states.hear(position(2.01, 0.0)) is None
    states.hear(attitude(4.0, 0.0))
    assert states.hear(position(4.0, 0.0)) is not None  # it has fallen silent


def test_an_estimator_that_has_failed_gives_no_state():
    states, state = States(), np.concatenate([np.zeros(3), [1.0], np.zeros(9)])
    assert states.hear(odometry(state, 1.0, quality=-1)) is None
    assert states.hear(odometry(state, 1.1, quality=1)) is not None


def test_frames_that_are_not_known_are_named():
    states = States()
    assert states.hear(odometry(np.concatenate([np.zeros(3), [1.0], np.zeros(9)]), 1.0, frame_id=21)) is None
    assert states.unknown_frames == "21 and 12"


def test_the_answer_that_took_least_tells_the_offset():
    ours = [100.0]
    clock = OffsetClock(lambda: ours[0])
    for there, back in ((0.030, 0.001), (0.002, 0.002), (0.001, 0.050)):
        asked = ours[0]
        ours[0] += there
        answer = ours[0] - 60.0
        ours[0] += back
        clock.answered(asked, answer)
    clock.stamped(ours[0] - 60.0 - 0.01)
    assert clock.is_synchronised
    assert clock.now() == pytest.approx(ours[0] - 60.0, abs=1e-9)


def test_without_answers_or_with_those_of_another_clock_the_earliest_state_is_fresh():
    ours = [100.0]
    clock = OffsetClock(lambda: ours[0])
    assert clock.now() == 0.0
    clock.answered(99.9, 1.7e9)
    for late in (0.03, 0.01, 0.02):
        ours[0] += 0.1
        clock.stamped(ours[0] - 60.0 - late)
    assert not clock.is_synchronised
    assert clock.now() - (ours[0] - 60.0 - 0.02) == pytest.approx(0.01)


@given(lie=st.floats(-0.99, 0.0))
def test_a_state_is_never_taken_for_one_that_is_still_to_come(lie):
    ours = [100.0]
    clock = OffsetClock(lambda: ours[0])
    clock.stamped(40.0)
    clock.answered(99.99, 40.0 + lie)
    assert clock.now() >= 40.0
    ours[0] += 0.3
    assert clock.now() - 40.0 >= 0.3 - 1e-9  # nothing more has come: it grows old


def test_a_clock_that_is_followed_never_goes_back():
    clock = FollowedClock()
    for stamp in (1.0, 3.0, 2.0):
        clock.stamped(stamp)
    clock.told(2.5)
    clock.answered(0.0, 9.0)
    assert clock.now() == clock.ours() == 3.0


@pytest.mark.parametrize("text", ["udpin:0.0.0.0:14540", "udpout:drone.local:1", "tcp:127.0.0.1:65535", "serial:/dev/ttyACM0:921600"])
def test_an_address_is_understood_with_whose_clock_counts(text):
    assert not address_of(text).follows_clock
    assert address_of(f"{text}?clock=vehicle").follows_clock
    assert address_of(text).device == (text if not text.startswith("serial") else "/dev/ttyACM0")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("mavlink", "mavlink needs an address: udpin:HOST:PORT"),
        ("mavlink:127.0.0.1:14540", "mavlink:127.0.0.1:14540 is no address: udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial"),
        ("mavlink:udpin:127.0.0.1:0", "has no port from 1 to 65535"),
        ("mavlink:udpin:127.0.0.1:99999", "has no port from 1 to 65535"),
        ("mavlink:serial:/dev/ttyACM0:0", "has no baud rate above 0"),
        ("mavlink:udpout:there-is.invalid:14540", "there-is.invalid:14540 cannot be opened: "),
        ("mavlink:udpin:[::1]:14540", "is no address: "),
        ("mavlink:udpin:127.0.0.1:1?fast", r"has an option that is not known: there is \?clock=vehicle"),
        ("mavlnk:udpin:127.0.0.1:1", "there is no vehicle named 'mavlnk:udpin:127.0.0.1:1'"),
        (
            "mavlink:serial:/dev/there-is-none:57600",
            "there-is-none:57600 (cannot be opened|needs the package pyserial): ",
        ),
        ("mavlink:tcp:127.0.0.1:1", "mavlink:tcp:127.0.0.1:1 cannot be opened: Connection refused"),
    ],
)
def test_an_address_that_does_not_do_is_one_line(name, reason):
    pytest.importorskip("pymavlink")
    with pytest.raises(InputError, match=f"on: .*{reason}") as caught:
        open_link(name, 0.01)
    assert "\n" not in str(caught.value)


def test_a_package_that_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pymavlink", None)
    with pytest.raises(InputError, match=r"on: mavlink needs the package pymavlink: pip install 'hotlap\[mavlink\]'"):
        open_link("mavlink:udpin:127.0.0.1:14540", 0.01)
