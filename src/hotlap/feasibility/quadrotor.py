"""What a quadrotor means: its thrust, speed and agility, and how late it follows its commands."""

from __future__ import annotations

import math

from hotlap.feasibility.finding import Finding, Level, note_if, warning_if
from hotlap.race.flight_performance import FASTEST, command_lag, hover_share, max_tilt, rate_damping, roll_acceleration, top_speed
from hotlap.race.quadrotor import Quadrotor

MINUTE = 60.0  # s
ROTORS = ("four", "five", "six", "seven", "eight")
SLUGGISH = 0.1  # s from a command to what it asks for; the drones of the built-in races take 0.03 to 0.1


def describe_quadrotor(quadrotor: Quadrotor) -> tuple[Finding, ...]:
    """Thrust, speed and agility of a quadrotor."""
    ratio, fastest = quadrotor.thrust_to_weight, top_speed(quadrotor)
    weak = "too little for racing" if ratio < 1.5 else ""
    dragless = not any((*quadrotor.drag, *quadrotor.body_drag, quadrotor.rotor_drag))
    unlimited = "no drag is given" if dragless else f"its drag does not hold it below {FASTEST:g} m/s"
    hover, tilt, roll = hover_share(quadrotor), max_tilt(quadrotor), roll_acceleration(quadrotor)
    speed, remark = (f"{fastest:.1f} m/s", "in level flight") if math.isfinite(fastest) else ("-", unlimited)
    rotors = f"with all {ROTORS[quadrotor.rotor_count - 4]} rotors"
    return (
        Finding("thrust-to-weight", f"{ratio:.2f}", weak, note_if(ratio < 1.5), {"thrust_to_weight": ratio}),
        Finding("hover throttle", f"{hover:.0%}", "of the largest thrust", figures={"hover_throttle": hover}),
        Finding("largest tilt", f"{math.degrees(tilt):.0f} deg", "that keeps its height", figures={"largest_tilt_rad": tilt}),
        Finding("top speed", speed, remark, figures={"top_speed_m_per_s": fastest}),
        Finding("roll acceleration", f"{roll:.0f} rad/s^2", rotors, figures={"roll_acceleration_rad_per_s2": roll}),
        _rate_loop(quadrotor),
        _damping(quadrotor),
        *_inertia(quadrotor),
        lag(quadrotor),
        Finding("dead time", f"{quadrotor.delay * 1e3:g} ms", "from command to rotors", figures={"dead_time_s": quadrotor.delay}),
        *_battery(quadrotor),
    )


def _rate_loop(quadrotor: Quadrotor) -> Finding:
    """How quick its rate loop is about roll, as its gain alone would have it."""
    gain = float(quadrotor.hover_rate_gain[0])
    figures = {"rate_loop_hz": gain / (2 * math.pi), "rate_loop_gain_per_s": gain, "settling_time_s": 3 / gain}
    return Finding("rate loop", f"{gain / (2 * math.pi):.1f} Hz", f"roll; settles in {3 / gain:.2f} s", figures=figures)


def lag(quadrotor: Quadrotor) -> Finding:
    """How long rates take to follow their command: in the controller's model they follow at once."""
    seconds = command_lag(quadrotor)
    remark = "1/rate_gain + motor_time: rates follow their commands so much later"
    slow = seconds > SLUGGISH
    remark += ", which no controller's model has" if slow else ""
    return Finding("lag", f"{seconds * 1e3:.0f} ms", remark, note_if(slow), {"lag_s": seconds})


def _damping(quadrotor: Quadrotor) -> Finding:
    """Whether the rate loop oscillates behind its motors."""
    damping = rate_damping(quadrotor)
    if not math.isfinite(damping):
        return Finding("rate loop damping", "-", "the motors follow at once (motor_time 0): it cannot oscillate")
    slow = "the motors are slow for this rate_gain: it will oscillate"
    remark = slow if damping < 0.5 else "of the loop behind the slower motor time"
    return Finding("rate loop damping", f"{damping:.2f}", remark, warning_if(damping < 0.5), {"rate_loop_damping": damping})


def _inertia(quadrotor: Quadrotor) -> list[Finding]:
    """Moments of inertia that no body has, as far as they may be measured ones."""
    if quadrotor.excess_inertia <= 1e-9:
        return []
    remark = "by which the largest moment exceeds the sum of the other two, as of no body: a measuring error is taken for granted"
    return [Finding("inertia", f"{quadrotor.excess_inertia:.1%}", remark, Level.NOTE, {"excess_inertia": quadrotor.excess_inertia})]


def _battery(quadrotor: Quadrotor) -> list[Finding]:
    """What the thrust loses while the battery is drawn down, where anything is said of it."""
    hover = quadrotor.charge_sag * (quadrotor.mass * quadrotor.gravity) ** 1.5 * MINUTE
    found = []
    if quadrotor.sag:
        remark = "of the thrust is lost by the end of the reference"
        found.append(Finding("battery sag", f"{quadrotor.sag:.0%}", remark, figures={"battery_sag": quadrotor.sag}))
    if hover:
        remark = "of the thrust is lost in each minute of hover, more in a race"
        found.append(Finding("battery sag", f"{hover:.1%}", remark, figures={"battery_sag_per_min": hover}))
    return found
