"""Settings: what the firmware is told on its command line, as data with reasons, and a user's own lines from a file.

In order: `DEFAULTS`, the vehicle's tuning, the user's lines, `required`. So a `diff all` keeps its gains and filters, and what a computer
needs that flies in lockstep comes last.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hotlap.core.errors import InputError
from hotlap.race.quadrotor import RotorLayout
from hotlap.system.regular_files import read_text
from hotlap.system.text_files import cause_of

IDLE = 0.055  # motor output at no throttle, as stock
RATE_UNIT = 10  # deg/s
MOST_RATE = 1990  # deg/s that full sticks can mean
LARGEST_FILE = 1 << 20  # bytes


@dataclass(frozen=True)
class Line:
    """One line for the command line.

    Attributes:
        text: as it is typed.
        source: the file that it comes from, "" for one of ours.
        number: its number there, from 1.
    """

    text: str
    source: str = ""
    number: int = 0


@dataclass(frozen=True)
class Group:
    """Lines of ours that have one reason."""

    reason: str
    texts: tuple[str, ...]


DEFAULTS = (
    Group(
        "a controller's commands are steps of a hundred a second: feedforward would turn each into a kick, smoothing would delay it",
        ("set f_roll = 0", "set f_pitch = 0", "set f_yaw = 0", "set rc_smoothing = OFF"),
    ),
)
"""What differs from stock unless the user's lines say otherwise."""

REQUIRED = (
    Group("the simulator has no such devices", ("feature -TELEMETRY", "feature -RSSI_ADC")),
    Group("motors turn one way, and at the least throttle too", ("feature -3D", "feature -MOTOR_STOP", "set motor_output_limit = 100")),
    Group("the board sits as the vehicle does", ("set align_board_roll = 0", "set align_board_pitch = 0", "set align_board_yaw = 0")),
    Group("and so does its gyro", ("set gyro_1_sensor_align = DEFAULT",)),
    Group("rates are held at the least thrust too", ("feature AIRMODE", "set airmode_start_throttle_percent = 0")),
    Group("the first switch arms", ("aux 0 0 0 1700 2100 0 0",)),
    Group("it arms at once and in any attitude", ("set pwr_on_arm_grace = 0", "set small_angle = 180")),
    Group("half a second of standing still is enough for a gyro without noise", ("set gyro_calib_duration = 50",)),
    Group("and any noise will do", ("set gyro_calib_noise_limit = 0",)),
    Group("nothing but the controller ends a flight", ("set runaway_takeoff_prevention = OFF", "set crash_recovery = OFF")),
    Group("a command acts at once", ("set acc_limit = 0", "set acc_limit_yaw = 0")),
    Group("every position of a stick counts", ("set min_check = 1000", "set max_check = 1990", "set deadband = 0", "set yaw_deadband = 0")),
    Group("channels come in this order, and none is a lost link", ("map AETR1234", "set rx_min_usec = 885", "set rx_max_usec = 2115")),
    Group("throttle is linear in the motors' output", ("set thr_mid = 50", "set thr_expo = 0", "set throttle_limit_type = OFF")),
    Group("and nothing is added to it", ("set throttle_boost = 0", "set thrust_linear = 0")),
    Group("sticks are linear in body rates", ("set rates_type = ACTUAL", "set roll_expo = 0", "set pitch_expo = 0", "set yaw_expo = 0")),
)
"""What a computer needs that flies in lockstep, whatever the vehicle."""

MIXERS = {
    RotorLayout.X: ("mixer QUADX", "set yaw_motors_reversed = OFF"),
    RotorLayout.PLUS: ("mixer QUADP", "set yaw_motors_reversed = ON"),
}
"""Where the rotors sit and how they turn, in hotlap's order of rotors."""

LEFT_OUT = re.compile(
    r"#|(batch|save|exit|reboot|diff|dump|version|status|help|board_name|manufacturer_id|mcu_id|signature|bl|msc|tasks|get"
    r"|feature|serial|mixer|aux|map|adjrange|rxrange|rxfail)\b|set\s+motor_pwm_protocol\b",
    re.IGNORECASE,
)
"""Lines that are left out: those that do not say how it flies, and what this world says itself."""

FRESH = "defaults"  # the first word of a line after which everything is stock, as in a `diff all`
DEVICES = re.compile(
    r"(resource|timer|dma|led|color|mode_color|beeper|beacon|vtx|vtxtable|servo|smix|displayport_\w*|bind_rx\w*)\b"
    r"|set\s+(osd|vtx|gps|led|beeper|blackbox|baro|mag|acc|align|gyro_\d|i2c|spi|flash|sdcard|adc|vbat|ibat|battery|bat_|current|camera|frsky"
    r"|crsf|serial|telemetry|tlm|report|rcdevice|max7456|pinio|usb|stats|displayport|dashboard|cms|motor_poles|dshot|use_unsynced"
    r"|esc_|sbus|spektrum|ibus|hott|mavlink|name|pilot|craft|box_user|failsafe|rx_spi|rssi|system|mcu|rangefinder|transponder|timezone)",
    re.IGNORECASE,
)
"""Lines about devices, names and links: one of them that the firmware refuses changes nothing in how a simulated drone flies."""

IDLE_LINE = re.compile(r"set\s+motor_idle\s*=\s*(\d+)\s*", re.IGNORECASE)


def read_lines(path: str | Path) -> tuple[Line, ...]:
    """A user's lines: a `diff all`, or as much of it as he likes.

    Comments, empty lines and what ends a session are left out.

    Raises:
        InputError: it cannot be read, or is no text.
    """
    try:
        path = Path(path).expanduser()
    except RuntimeError as error:
        raise InputError(str(path), "", f"is no usable path: {cause_of(error)}") from None
    text = read_text(path, LARGEST_FILE, "these are no lines of Betaflight's command line")
    lines = (Line(line.strip(), str(path), number) for number, line in enumerate(text.splitlines(), 1))
    kept = tuple(line for line in lines if line.text and not LEFT_OUT.match(line.text))
    if any(not line.text.isprintable() for line in kept):
        raise InputError(str(path), "", "is no text that one could type on Betaflight's command line")
    return kept


def configuration(layout: RotorLayout, full_stick: int, tuning: Sequence[str] = (), own: Sequence[Line] = ()) -> tuple[Line, ...]:
    """All lines for a vehicle, in order.

    Args:
        layout: of its rotors.
        full_stick: [deg/s] that a full stick means, a multiple of 10.
        tuning: lines of the vehicle.
        own: lines of the user; one that resets everything resets `DEFAULTS` and the vehicle's tuning, too.
    """
    before = [*(text for group in DEFAULTS for text in group.texts), *tuning]
    starts = [place for place, line in enumerate(own) if line.text.lower().startswith(FRESH)]
    if starts:
        before, own = [], own[starts[-1] + 1 :]
    rates = [f"set {axis}_{what} = {full_stick // RATE_UNIT}" for axis in ("roll", "pitch", "yaw") for what in ("rc_rate", "srate")]
    after = [text for group in REQUIRED for text in group.texts] + rates + list(MIXERS[layout])
    return (*map(Line, before), *own, *map(Line, after))


def motor_idle(lines: Sequence[Line]) -> float:
    """Motor output at no throttle [-] with lines."""
    found = [match for line in lines if (match := IDLE_LINE.fullmatch(line.text))]
    return 1e-4 * float(found[-1][1]) if found else IDLE


def full_stick_for(rate: float) -> int:
    """What a full stick must mean [deg/s] so that a body rate [rad/s] can be commanded; no more, for sticks are whole numbers."""
    return min(RATE_UNIT * math.ceil(math.degrees(rate) / RATE_UNIT), MOST_RATE)
