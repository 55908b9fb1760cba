"""Race: a track, the vehicle that flies it, and everything that decides how the flight is controlled and judged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import Any, ClassVar

from pydantic import Field, ValidationInfo, field_validator, model_validator

from hotlap.race.controller_kind import Solver, law_of
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.race.observer import ObserverSettings
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.schema import Described, NotNegative, Positive
from hotlap.race.track import Track


class Ramp(Described):
    """Limits of a plan that grow over the first metres (rpg_time_optimal's thrust and rate ramp)."""

    distance: Positive
    """[m] along the waypoints until the limits are full."""
    thrust_to_weight: float = Field(gt=1)
    """[-] at the start."""
    rate: Positive
    """[rad/s] roll and pitch rate at the start."""


class PlanDynamics(StrEnum):
    """What the plan knows of the vehicle.

    FULL: everything: rotors and body rates begin at rest, rotor thrust follows its command with the motors' lag, the rate loop's
        command keeps within bounds, and all of the vehicle's drags act.
    IDEAL: the model of rpg_time_optimal, which the paper plans with: body rates are free at the start, rotor thrust acts at once, drag is
        linear and the same in all directions.
    """

    FULL = "full"
    IDEAL = "ideal"


class PlanningSettings(Described):
    """Settings of the planner: the quadrotor that it plans for, and the limits of the plan."""

    quadrotor: Quadrotor | None = None
    """the planning model. None: the vehicle with `thrust_share` of its thrust."""
    thrust_share: float | None = Field(default=None, gt=0, le=1)
    """[-] share of the vehicle's rotor thrust left to the plan where no `quadrotor` is given. None: `hotlap tune` chooses the boldest that
    its controller holds, and all other commands take 0.85."""
    v_max: float | None = Field(default=None, gt=0, le=200)
    """[m/s] terminal speed of the planner's linear drag at full thrust in level flight. None: the quadrotor's own drag."""
    tolerance: float = Field(default=0.2, gt=0, le=5)
    """[m] how far from a waypoint without an opening the plan may pass."""
    clearance: NotNegative | None = None
    """[m] kept between the vehicle and frames, obstacles and box. None: half of the room of a gate, else the vehicle's radius."""
    dynamics: PlanDynamics = PlanDynamics.FULL
    """what the plan knows of the vehicle."""
    rate_share: float = Field(default=0.6, gt=0, le=1)
    """[-] share of `controller.rates` that the plan's rate commands use, for the dynamics "full"."""
    nodes: int = Field(default=12, ge=4, le=100)
    """shooting intervals between two waypoints."""
    ramp: Ramp | None = None
    """limits that grow over the first metres. None: full from the start."""
    floor: float | None = None
    """[m] height below which the plan does not go. None: the track's floor."""

    @property
    def free(self) -> bool:
        """Whether it is left open how bold the plan is."""
        return self.quadrotor is None and self.thrust_share is None


class ReferenceTime(StrEnum):
    """The moment at which a predicting controller reads its reference."""

    EXECUTION = "execution"
    NOW = "now"


def _tunable(values: dict[str, Any], name: str) -> tuple[float, ...]:
    """Least, largest or first values of the parameters that this kind of controller is tuned by: a field of `Tunable`."""
    return getattr(TUNABLE[values.get("kind", ControllerKind.MPC)], name)


class SegmentSwitch(StrEnum):
    """When the controller changes to the parameters of the next segment.

    TIME: when the reference enters it, for the whole horizon.
    NODE: each node of the horizon has the weights of the segment that the reference is in at that node; the horizon itself as for TIME.
    DISTANCE: when the drone comes close to the point at which the reference enters it, for the whole horizon, as in the released code.
    """

    TIME = "time"
    NODE = "node"
    DISTANCE = "distance"


USUAL_SHARE = 0.85  # of the rotor thrust, for a plan of which nothing is said: docs/planning.md
LEAST_THRUST = 0.1  # m/s^2, of a collective command
USUAL_NODES, USUAL_PERIOD = 20, 0.01  # s
MOST_NODES = 100


class ControllerSettings(Described):
    """Settings of the controller that are not tuned (Eq. 3 of the paper)."""

    renamed: ClassVar[Mapping[str, str]] = {"handover": "segment_switch", "handover_distance": "segment_switch_distance"}

    kind: ControllerKind = ControllerKind.MPC
    """which controller flies."""
    nodes: int = Field(default=USUAL_NODES, ge=2, le=MOST_NODES)
    """N, intervals of the horizon."""
    period: float = Field(default=USUAL_PERIOD, gt=0, le=0.1)
    """[s] of the control loop."""
    sweeps: int = Field(default=2, ge=1, le=10)
    """box-constrained Riccati sweeps per control step."""
    solver: Solver | None = None
    """how an MPC solves its problem. None: "real_time" with 20 nodes, 0.01 s, two sweeps or more and up to 3.5 s, else "line_search"."""
    thrust: tuple[NotNegative, Positive] = (LEAST_THRUST, 20.0)
    """[m/s^2] least and largest collective thrust per mass (in a race that does not say it: up to what the model's rotors give)."""
    rates: tuple[Positive, Positive, Positive] = (10.0, 10.0, 3.0)
    """[rad/s] largest body rates (symmetric bounds)."""
    input_weights: tuple[Positive, Positive, Positive] = (1.0, 1.0, 1.0)
    """R of thrust, roll and pitch rate, yaw rate."""
    horizon_unit: Positive = 0.5
    """[s] time that a horizon parameter of 1 stands for."""
    feed_forward: bool = True
    """take the reference's inputs as the inputs to stay close to (else hover)."""
    predict: bool = True
    """predict the state over the model's dead time, and over a share of its lag."""
    lag_lead: float = Field(default=0.5, ge=0, le=1)
    """[-] that share: of the lag of motors and rate loop, which the controller's model does not have."""
    offset_free: bool | None = None
    """estimate thrust effectiveness and disturbance in flight, and make up for them. None: where the plan leaves the thrust for it."""
    observer: ObserverSettings = ObserverSettings()
    """how fast these are estimated."""
    reference_drag: bool = True
    """make up for the model's drag at the velocities and attitudes of the plan."""
    reference_time: ReferenceTime = ReferenceTime.EXECUTION
    """what a predicting controller compares with: the reference when the command acts, or now."""
    segment_switch: SegmentSwitch = SegmentSwitch.TIME
    """from when on it takes the parameters of the next segment."""
    segment_switch_distance: Positive = 6.0
    """[m] how close is close, for the segment_switch "distance"."""
    low: tuple[Positive, ...] = Field(default_factory=lambda values: _tunable(values, "low"))
    """least values of what is tuned: Q_pos_xy, Q_pos_z, Q_attitude, Q_velocity, horizon; or of what another kind has."""
    high: tuple[Positive, ...] = Field(default_factory=lambda values: _tunable(values, "high"))
    """largest values of the same."""
    default: tuple[Positive, ...] = Field(default_factory=lambda values: _tunable(values, "default"))
    """first values of the same."""

    @model_validator(mode="after")
    def _ordered(self) -> ControllerSettings:
        if self.thrust[0] >= self.thrust[1]:
            raise ValueError("thrust: the least is not below the largest")
        steps = self.period / PLANT_STEP
        if abs(steps - round(steps)) > 1e-6:
            raise ValueError(f"period: a multiple of the plant's step of {PLANT_STEP * 1e3:g} ms, not {self.period * 1e3:g} ms")
        names = TUNABLE[self.kind].names
        for key, values in (("low", self.low), ("high", self.high), ("default", self.default)):
            if len(values) != len(names):
                raise ValueError(f"{key}: must have {len(names)} values ({', '.join(names)}), not {len(values)}")
        for i, (low, value, high) in enumerate(zip(self.low, self.default, self.high, strict=True)):
            if low >= high:
                raise ValueError(f"low[{i}]: {low:g} is not below high[{i}] = {high:g}")
            if not low <= value <= high:
                raise ValueError(f"default[{i}]: {value:g} is not within its bounds [{low:g}, {high:g}]")
        self._check_horizon()
        return self

    def _check_horizon(self) -> None:
        """Refuse a horizon on which the controller would not follow its reference, even with a vehicle equal to its model."""
        if not self._horizon_index:
            return
        if self.solver is Solver.REAL_TIME and not self.converges_in_real_time:
            raise ValueError(f'solver: "real_time" converges with {REAL_TIME_RANGE}; "line_search" does without')
        if self.period > LONGEST_PERIOD + ALMOST:
            raise ValueError(f"period: an MPC follows with up to {LONGEST_PERIOD:g} s, not {self.period:g} s")
        if self.longest_horizon > LONGEST_HORIZON + ALMOST:
            raise ValueError(f"high[{self._horizon_index}]: a horizon of {self.longest_horizon:g} s is longer than {LONGEST_HORIZON:g} s")
        if self.widest_spacing > WIDEST_SPACING + ALMOST:
            apart = f"{self.nodes} nodes over a horizon of up to {self.longest_horizon:g} s lie {self.widest_spacing:.3g} s apart"
            nodes, high = math.ceil(self.longest_horizon / WIDEST_SPACING - ALMOST), WIDEST_SPACING * self.nodes / self.horizon_unit
            cure = f"set {nodes} nodes, or high[{self._horizon_index}] = {high:.3g}"
            raise ValueError(f"nodes: {apart}, and an MPC follows with up to {WIDEST_SPACING:g} s: {cure}")

    @property
    def _horizon_index(self) -> int:
        """Place of the horizon among the parameters; 0 for a controller without one."""
        names = TUNABLE[self.kind].names
        return names.index("horizon") if "horizon" in names else 0

    @property
    def longest_horizon(self) -> float:
        """[s] The longest horizon that may be tuned; 0 for a controller without one."""
        return self.high[self._horizon_index] * self.horizon_unit if self._horizon_index else 0.0

    @property
    def widest_spacing(self) -> float:
        """[s] between the nodes of that."""
        return self.longest_horizon / self.nodes

    @property
    def converges_in_real_time(self) -> bool:
        """Whether one linearisation a control step is known to suffice over all horizons that may be tuned."""
        quick = self.nodes <= USUAL_NODES and self.sweeps >= 2 and self.period <= USUAL_PERIOD
        return quick and self.longest_horizon <= 3.5 + ALMOST and self.widest_spacing <= 0.175 + ALMOST

    @property
    def law(self) -> str:
        """The control law: the kind, and how it solves its problem."""
        if not self._horizon_index:
            return law_of(self.kind)
        usual = self.converges_in_real_time and self.nodes == USUAL_NODES and self.period == USUAL_PERIOD
        return law_of(self.kind, self.solver or (Solver.REAL_TIME if usual else Solver.LINE_SEARCH))


REAL_TIME_RANGE = "up to 20 nodes, at least 2 sweeps, a period of up to 0.01 s and a horizon of up to 3.5 s, 0.175 s a node"
WIDEST_SPACING, LONGEST_PERIOD, LONGEST_HORIZON = 0.2, 0.05, 14.0
"""[s] Between nodes, of the control loop and of the horizon: an MPC follows what its model can fly to 0.03 m (docs/controller.md)."""
ALMOST = 1e-9
PLANT_STEP = 0.0025  # s, of the built-in plant


class NoiseSettings(Described):
    """Standard deviations of the noise, which differs from flight to flight."""

    thrust: NotNegative = 0.02
    """[-] relative actuation noise, correlated over `time`."""
    rates: NotNegative = 0.1
    """[rad/s] actuation noise of the body rates, correlated over `time`."""
    time: NotNegative = 0.1
    """[s] correlation time of the actuation noise."""
    thrust_bias: NotNegative = 0.01
    """[-] relative thrust error, constant over a flight."""
    position: NotNegative = 0.05
    """[m] of the initial state."""
    velocity: NotNegative = 0.05
    """[m/s] of the initial state."""
    attitude: NotNegative = 0.01
    """[-] of the initial state, quaternion parts."""
    measured_position: NotNegative = 0.0
    """[m] of the state that the controller sees, white."""
    measured_velocity: NotNegative = 0.0
    """[m/s] likewise."""
    measured_attitude: NotNegative = 0.0
    """[-] likewise, quaternion parts."""
    wind: NotNegative = 0.0
    """[m/s^2] (world) acceleration by gusts, correlated over `wind_time`."""
    wind_time: Positive = 1.0
    """[s] correlation time of the gusts."""
    steady_wind: NotNegative = 0.0
    """[m/s^2] (world) acceleration by a steady wind, level, from a direction that each flight draws."""


class GateRule(StrEnum):
    """When a gate counts as passed.

    CLOCK: close enough at the time at which the reference passes it (the paper, Eq. 6).
    CLOSEST: close enough at some time in a window around it.
    OPENING: where the drone crosses the gate's plane, in order and in its direction, it is inside the opening with all of its size; a point
        without orientation counts as for CLOSEST, in order. The rule of tracks whose gates have openings or orientations.
    RELEASED: the released code's: closest approach over the whole flight, last gate unchecked.
    """

    CLOCK = "clock"
    CLOSEST = "closest"
    OPENING = "opening"
    RELEASED = "released"


def _gate_distance(values: dict[str, Any]) -> float:
    """[m] The paper's 1.3 (below Eq. 6), or the released code's 1.2."""
    return 1.2 if values.get("rule") == GateRule.RELEASED else 1.3


class JudgeSettings(Described):
    """How a flight is judged."""

    rule: GateRule = GateRule.CLOCK
    """when a gate counts as passed ("opening" where nothing is said and a gate has an opening or an orientation)."""
    distance: float = Field(default_factory=_gate_distance, gt=0, le=20)
    """[m] how close is close enough, for gates without an opening; default 1.3, 1.2 for the rule "released"."""
    crash: float = Field(default=10.0, gt=0, le=1000)
    """[m] distance from the clocked reference beyond which the drone has crashed."""
    window: tuple[NotNegative, NotNegative] = (1.0, 2.0)
    """[s] before and after the reference's passage, for the rules "closest" and "opening"."""
    rate_crash: float = Field(default=60.0, gt=0)
    """[rad/s] body rate beyond which the drone has crashed."""
    fly_on: bool = False
    """go on after a missed gate until the crash or the end (for dense scores)."""


class Race(Described):
    """Everything that a flight depends on, apart from parameters and seed."""

    name: str = Field(min_length=1)
    """what it is called."""
    track: Track
    """what is flown."""
    vehicle: Quadrotor
    """the quadrotor that flies it."""
    model: Quadrotor | None = None
    """the vehicle as controller and planner know it. None: the vehicle itself."""
    planning: PlanningSettings = PlanningSettings()
    """what the planner may use."""
    controller: ControllerSettings = ControllerSettings()
    """settings of the controller that are not tuned."""
    noise: NoiseSettings = NoiseSettings()
    """what differs from flight to flight."""
    judge: JudgeSettings = Field(default=JudgeSettings(), validate_default=True)
    """how a flight is judged."""
    provenance: str = ""
    """where the settings come from."""

    @model_validator(mode="after")
    def _up_to_the_rotors(self) -> Race:
        """A thrust bound that nobody has set is what the rotors give."""
        controller = self.controller
        if "thrust" in controller.model_fields_set:
            return self
        bounded = controller.model_copy(update={"thrust": (LEAST_THRUST, self.control_model.max_acceleration)})
        bounded.model_fields_set.discard("thrust")  # a race that builds on this one with another vehicle has the bound of that
        object.__setattr__(self, "controller", bounded)
        return self

    @field_validator("judge")
    @classmethod
    def _by_openings(cls, judge: JudgeSettings, known: ValidationInfo) -> JudgeSettings:
        """Gates with openings or orientations are judged by them, unless the race says otherwise."""
        track = known.data.get("track")
        if track is None or not track.has_openings or "rule" in judge.model_fields_set:
            return judge
        return judge.model_copy(update={"rule": GateRule.OPENING})

    def with_controller(self, kind: ControllerKind) -> Race:
        """The same race flown by another controller, with the bounds and defaults of its kind."""
        kept = self.controller.model_dump(exclude={"kind", "low", "high", "default"})
        settings = self.controller if kind is self.controller.kind else ControllerSettings(kind=kind, **kept)
        return self.model_copy(update={"controller": settings})

    @model_validator(mode="after")
    def _as_many_rotors(self) -> Race:
        known, there = self.control_model.rotor_count, self.vehicle.rotor_count
        if known != there:
            raise ValueError(f"model: has {known} rotors, and the vehicle {there}: its rate loop must know all of them")
        return self

    @property
    def control_model(self) -> Quadrotor:
        """The vehicle as the controller knows it."""
        return self.model or self.vehicle

    @property
    def prediction(self) -> float:
        """[s] over which the controller predicts the state: the dead time that it knows, and a share of the lag."""
        if not self.controller.predict:
            return 0.0
        return self.control_model.delay + self.controller.lag_lead * self.control_model.lag

    @property
    def thrust_share(self) -> float:
        """Share [-] of the control model's rotor thrust that is asked for the plan, where `planning.quadrotor` does not say it."""
        return USUAL_SHARE if self.planning.thrust_share is None else self.planning.thrust_share

    def with_share(self, share: float) -> Race:
        """The same race, planned with a share of the thrust."""
        return self.model_copy(update={"planning": self.planning.model_copy(update={"thrust_share": share})})

    @property
    def planning_model(self) -> Quadrotor:
        """The quadrotor that the planner plans for: `planning.quadrotor`, or the control model with a share of its rotor thrust."""
        if self.planning.quadrotor is not None:
            return self.planning.quadrotor
        low, high = self.control_model.rotor_thrust
        high = min(self.thrust_share * high, 0.95 * self.controller.thrust[1] * self.control_model.mass / self.control_model.rotor_count)
        return self.control_model.model_copy(update={"rotor_thrust": (min(low, 0.5 * high), high)})

    @property
    def planning_drag(self) -> float:
        """[1/s] linear drag of the planning model, isotropic (rpg_time_optimal's c_d where v_max is given)."""
        if self.planning.v_max is None:
            return sum(self.planning_model.drag) / 3
        level = math.sqrt(max(self.planning_model.max_acceleration**2 - self.planning_model.gravity**2, 0.0))
        return level / self.planning.v_max
