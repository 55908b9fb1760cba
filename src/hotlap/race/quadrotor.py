"""Quadrotor: the physical parameters of the vehicle, and every convention of hotlap in one place.

Conventions
    World frame: x forward, y left, z up; gravity along -z. Body frame: x forward, y left, z up.
    Attitude: unit quaternion (w, x, y, z), body to world: v_world = q o v_body o conj(q).
    Units: SI, radians. Body rates in the body frame.
    Rotors: thrust along body +z. Four in RotorLayout x: 0 front left, 1 front right, 2 back right, 3 back left;
    layout plus: 0 front, 1 left, 2 back, 3 right. Any others in the order in which they are listed.
    Command of a controller: collective thrust per mass [m/s^2] and three body rates [rad/s].
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from hotlap.dynamics.mixers import Mixer
from hotlap.race.battery import Battery
from hotlap.race.rate_loop import MOST_DELAY as MOST_RATE_DELAY
from hotlap.race.rate_loop import MotorLag, Output, RateLoop
from hotlap.race.rotors import Rotor, RotorLayout, farthest, fault_of, rotor_positions, rotor_spins, torques_of
from hotlap.race.schema import Described, NotNegative, Positive

GRAVITY = 9.81  # m/s^2
MEASURED = 0.02  # share by which measured moments of inertia may break the triangle rule, and lengths differ
MOST_DELAY = 0.25  # s
PROPELLERS = 1.5  # radius of a quadrotor over its arm: propellers reach about half an arm further


class Quadrotor(Described):
    """Physical parameters of a quadrotor, and of the rate loop in its flight controller."""

    name: str = Field(min_length=1)
    """what it is called."""
    mass: Positive
    """[kg] ready to fly, battery included."""
    inertia: tuple[Positive, Positive, Positive]
    """[kg m^2] (body) principal moments."""
    arm: Positive
    """[m] distance of a rotor from the centre of mass; of the farthest where `rotors` lists them."""
    layout: RotorLayout = RotorLayout.X
    """where four rotors sit."""
    rotors: tuple[Rotor, ...] | None = None
    """where other rotors sit, four to eight: a list of [x, y, spin], x forward and y left [m], spin 1 or -1 the sign of the yaw torque
    (1: the rotor turns clockwise, seen from above). None: four, as `layout` says."""
    rotor_thrust: tuple[NotNegative, Positive]
    """[N] least and largest thrust of one rotor."""
    torque_ratio: Positive
    """[m] yaw torque over thrust of a rotor."""
    motor_time: tuple[NotNegative, NotNegative] = (0.02, 0.04)
    """[s] time constant of rotor speed, up and down."""
    motor_lag: MotorLag = MotorLag.SPEED
    """what follows with `motor_time`."""
    rotor_inertia: NotNegative = 0.0
    """[kg m^2] moment of inertia of a rotor with what turns in its motor: what speeds it up turns the vehicle. It needs `rotor_speed`."""
    rotor_speed: Positive | None = None
    """[rad/s] of a rotor at its largest thrust. None: not known."""
    inflow: NotNegative = 0.0
    """[N^0.5 s/m] loss of thrust by motion along the rotors' axis: thrust = s^2 - inflow s v_z, with s the root of the thrust at rest."""
    drag: tuple[NotNegative, NotNegative, NotNegative] = (0.0, 0.0, 0.0)
    """[1/s] (body) linear drag per mass."""
    rotor_drag: NotNegative = 0.0
    """[N^0.5 s/m] in-plane drag: force = -rotor_drag * sum sqrt(thrust) * v_body_xy (RotorS)."""
    body_drag: tuple[NotNegative, NotNegative, NotNegative] = (0.0, 0.0, 0.0)
    """[N s^2/m^2] (body) quadratic drag: force = -body_drag v |v| along each axis."""
    rate_gain: tuple[Positive, Positive, Positive] = (20.0, 20.0, 8.0)
    """[1/s] (body) proportional gain of the rate loop."""
    torque_damping: NotNegative = 0.0
    """[-] share of the present torque that the rate loop subtracts (RotorS's second gain)."""
    rate_delay: float = Field(default=0.0, ge=0.0, le=MOST_RATE_DELAY)
    """[s] age of the body rates that the rate loop acts on: dead time within the loop, besides `delay`."""
    rate_loop: RateLoop | None = None
    """a PID rate loop with gains of its own. None: a proportional one, with `rate_gain`."""
    mixer: Mixer = Mixer.CLIP
    """what becomes of rotor thrusts beyond their limits."""
    rate_limit: tuple[Positive, Positive, NotNegative] = (10.0, 10.0, 3.0)
    """[rad/s] (body) rates that a plan may ask for."""
    delay: float = Field(default=0.0, ge=0.0, le=MOST_DELAY)
    """[s] dead time from command to rotors."""
    gravity: Positive = GRAVITY
    """[m/s^2] downward acceleration."""
    radius: NotNegative | None = None
    """[m] of the ball that the vehicle fills, propellers included. None: 1.5 times the arm."""
    battery: Battery | None = None
    """what thrust loses while the battery is drawn down. None: nothing."""
    provenance: str = ""
    """where the numbers come from."""

    @field_validator("rotors")
    @classmethod
    def _can_be_flown(cls, rotors: tuple[Rotor, ...] | None) -> tuple[Rotor, ...] | None:
        fault = "" if rotors is None else fault_of(rotors)
        if fault:
            raise ValueError(fault)
        return rotors

    @field_validator("mass")
    @classmethod
    def _kilograms(cls, mass: float) -> float:
        if mass > 100:
            raise ValueError(f"{mass:g} kg is no quadrotor; mass is in kilograms (did you mean {mass / 1000:g}?)")
        return mass

    @field_validator("arm")
    @classmethod
    def _metres(cls, arm: float) -> float:
        if arm > 3:
            raise ValueError(f"{arm:g} m is no quadrotor; arm is in metres (did you mean {arm / 1000:g}?)")
        return arm

    @field_validator("motor_time")
    @classmethod
    def _seconds(cls, motor_time: tuple[float, float]) -> tuple[float, float]:
        if max(motor_time) > 1:
            raise ValueError(f"{max(motor_time):g} s is no motor; motor_time is in seconds")
        return motor_time

    @model_validator(mode="after")
    def _possible(self) -> Quadrotor:
        away = self.arm if self.rotors is None else farthest(self.rotors)
        if abs(away - self.arm) > MEASURED * away:
            raise ValueError(f"arm: the farthest of the rotors is {away:.4g} m from the centre of mass, not {self.arm:g}")
        largest = max(self.inertia)
        if self.excess_inertia > MEASURED:
            raise ValueError(f"inertia: no body has {list(self.inertia)}: the largest moment exceeds the sum of the other two")
        if largest > self.mass * 10 * self.arm**2:
            raise ValueError(f"inertia: {largest:g} kg m^2 is too much for {self.mass:g} kg on an arm of {self.arm:g} m")
        if self.rotor_thrust[0] >= self.rotor_thrust[1]:
            raise ValueError("rotor_thrust: the least thrust is not below the largest")
        if self.thrust_to_weight <= 1:
            raise ValueError(
                f"rotor_thrust: cannot hover, thrust-to-weight is {self.thrust_to_weight:.2f} (rotor_thrust is in newtons a rotor)"
            )
        if self.rotor_inertia > 0 and self.rotor_speed is None:
            raise ValueError("rotor_speed: is missing; rotor_inertia needs it: [rad/s] of a rotor at its largest thrust")
        if self.thrust_to_weight > 50:
            raise ValueError(f"rotor_thrust: thrust-to-weight of {self.thrust_to_weight:.0f} (rotor_thrust: N a rotor, mass: kg)")
        return self

    @property
    def rotor_count(self) -> int:
        """How many rotors it has."""
        return 4 if self.rotors is None else len(self.rotors)

    @property
    def rotor_positions(self) -> NDArray[np.float64]:
        """Where the rotors sit, shape (n, 2) [m] (body): x forward, y left."""
        return rotor_positions(self.layout, self.arm) if self.rotors is None else np.array(self.rotors)[:, :2]

    @property
    def rotor_spins(self) -> NDArray[np.float64]:
        """Sign of the yaw torque of each rotor, shape (n,)."""
        return rotor_spins(self.layout) if self.rotors is None else np.array(self.rotors)[:, 2]

    @property
    def thrust_to_weight(self) -> float:
        """Largest collective thrust over weight [-]."""
        return self.rotor_count * self.rotor_thrust[1] / (self.mass * self.gravity)

    @property
    def max_acceleration(self) -> float:
        """Largest collective thrust per mass [m/s^2]."""
        return self.rotor_count * self.rotor_thrust[1] / self.mass

    @property
    def outer_radius(self) -> float:
        """[m] of the ball that the vehicle fills: what it keeps clear of frames and obstacles."""
        return PROPELLERS * self.arm if self.radius is None else self.radius

    @property
    def sag(self) -> float:
        """Share of thrust [-] that the battery has lost at the end of the reference by time alone."""
        return 0.0 if self.battery is None else self.battery.sag

    @property
    def charge_sag(self) -> float:
        """Share of thrust [1/(s N^1.5)] that the battery loses in each second for each N^1.5 of thrust."""
        return 0.0 if self.battery is None else self.battery.charge_sag(self.mass * self.gravity)

    @property
    def lag(self) -> float:
        """[s] by which roll and pitch rates follow their commands: of rate loop and motors, 1 / rate_gain + motor_time in the mean."""
        gain = self.hover_rate_gain
        return float(2 / (gain[0] + gain[1]) + sum(self.motor_time) / 2)

    @property
    def torque_matrix(self) -> NDArray[np.float64]:
        """Torque (body) of each rotor per newton of thrust, shape (3, n) [m]."""
        return torques_of(self.rotor_positions, self.rotor_spins, self.torque_ratio)

    @property
    def signal_mix(self) -> NDArray[np.float64]:
        """What a rotor's signal gets of those of roll, pitch and yaw, shape (n, 3): levers over the longest of all, and spins."""
        levers = torques_of(self.rotor_positions, self.rotor_spins, 1.0).T
        return levers / np.array([*[np.abs(levers[:, :2]).max()] * 2, 1.0])

    @property
    def hover_rate_gain(self) -> NDArray[np.float64]:
        """Proportional gain of the rate loop in hover, shape (3,) [1/s]: `rate_gain`, or what the signals of `rate_loop` come to."""
        if self.rate_loop is None:
            return np.array(self.rate_gain)
        largest, idle, slope = self.rotor_thrust[1], self.rate_loop.idle, self.rotor_thrust[1]
        if self.rate_loop.output is Output.SPEED:
            slope = 2 * largest * (1 - idle) / math.sqrt(self.thrust_to_weight)
        return slope * np.array(self.rate_loop.p) * (self.torque_matrix * self.signal_mix.T).sum(axis=1) / self.inertia_vector

    @property
    def excess_inertia(self) -> float:
        """Share [-] by which the largest moment exceeds the sum of the other two, which no body's does; 0 or less: a body's."""
        *others, largest = sorted(self.inertia)
        return largest / sum(others) - 1

    @property
    def inertia_vector(self) -> NDArray[np.float64]:
        """Principal moments, shape (3,) [kg m^2]."""
        return np.array(self.inertia)
