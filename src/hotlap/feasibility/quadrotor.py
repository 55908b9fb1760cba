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
    gain = float(quadrotor.hover_rate_gain[0])
    return (
        Finding("thrust-to-weight", f"{ratio:.2f}", weak, note_if(ratio < 1.5)),
        Finding("hover throttle", f"{hover_share(quadrotor):.0%}", "of the largest thrust"),
        Finding("largest tilt", f"{math.degrees(max_tilt(quadrotor)):.0f} deg", "that keeps its height"),
        Finding("top speed", f"{fastest:.1f} m/s", "in level flight") if math.isfinite(fastest) else Finding("top speed", "-", unlimited),
        Finding("roll acceleration", f"{roll_acceleration(quadrotor):.0f} rad/s^2", f"with all {ROTORS[quadrotor.rotor_count - 4]} rotors"),
        Finding("rate loop", f"{gain / (2 * math.pi):.1f} Hz", f"roll; settles in {3 / gain:.2f} s"),
        _damping(quadrotor),
        *_inertia(quadrotor),
        lag(quadrotor),
        Finding("dead time", f"{quadrotor.delay * 1e3:g} ms", "from command to rotors"),
        *_battery(quadrotor),
    )


def lag(quadrotor: Quadrotor) -> Finding:
    """How long rates take to follow their command: in the controller's model they follow at once."""
    seconds = command_lag(quadrotor)
    remark = "1/rate_gain + motor_time: rates follow their commands so much later"
    slow = seconds > SLUGGISH
    return Finding("lag", f"{seconds * 1e3:.0f} ms", f"{remark}, which no controller's model has" if slow else remark, note_if(slow))


def _damping(quadrotor: Quadrotor) -> Finding:
    """Whether the rate loop oscillates behind its motors."""
    damping = rate_damping(quadrotor)
    if not math.isfinite(damping):
        return Finding("rate loop damping", "-", "the motors follow at once (motor_time 0): it cannot oscillate")
    slow = "the motors are slow for this rate_gain: it will oscillate"
    remark = slow if damping < 0.5 else "of the loop behind the slower motor time"
    return Finding("rate loop damping", f"{damping:.2f}", remark, warning_if(damping < 0.5))


def _inertia(quadrotor: Quadrotor) -> list[Finding]:
    """Moments of inertia that no body has, as far as they may be measured ones."""
    if quadrotor.excess_inertia <= 1e-9:
        return []
    remark = "by which the largest moment exceeds the sum of the other two, as of no body: a measuring error is taken for granted"
    return [Finding("inertia", f"{quadrotor.excess_inertia:.1%}", remark, Level.NOTE)]


def _battery(quadrotor: Quadrotor) -> list[Finding]:
    """What the thrust loses while the battery is drawn down, where anything is said of it."""
    hover = quadrotor.charge_sag * (quadrotor.mass * quadrotor.gravity) ** 1.5 * MINUTE
    found = []
    if quadrotor.sag:
        found.append(Finding("battery sag", f"{quadrotor.sag:.0%}", "of the thrust is lost by the end of the reference"))
    if hover:
        found.append(Finding("battery sag", f"{hover:.1%}", "of the thrust is lost in each minute of hover, more in a race"))
    return found
