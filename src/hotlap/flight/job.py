"""The input of the compiled flight core: settings and flights as plain numbers and arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

LOG_COLUMNS = 21  # p q v w, command, estimates; the rotor thrusts stand behind them


class Settings(NamedTuple):
    """Settings that all flights share, as plain numbers; see `ControllerSettings` and `NoiseSettings`.

    Attributes:
        nodes, sweeps: of the controller.
        node_parts: parts of a node in which `line_search` flies its model.
        stop_early: leave out sweeps that would change nothing; False: every control step is the same work.
        period: [s] of the control loop.
        rotors: of the vehicle.
        steps: of the plant in each period.
        plant_step: [s].
        table_period: [s] between rows of the reference.
        lead: [s] by which the reference that the controller compares with lies ahead.
        predicted_periods, predicted_rest: whole periods, and the rest [s], over which it predicts the state.
        feed_forward: the reference's inputs, else hover.
        gravity: [m/s^2] of the controller's model.
        segment_switch: when the next segment's parameters are taken, a number of `segment_switch`.
        segment_switch_distance: [m].
        thrust_noise, rate_noise: standard deviations of the actuation noise.
        noise_memory: factor by which it decays in one period.
        thrust_bias, position, velocity, attitude: standard deviations of what differs from flight to flight.
        measured_position, measured_velocity, measured_attitude: those of the state that the controller sees.
        wind, wind_memory: standard deviation of the gusts, and factor by which they decay in one period.
        steady_wind: [m/s^2].
        sagging: whether a battery takes thrust from any of the flights.
        duration: [s] of the reference.
        offset_free: whether the observer estimates thrust effectiveness and disturbance; see `observer`.
        corrected: whether target and prediction are corrected, for what is estimated or for drag.
        acted_periods, acted_rest: the known dead time in whole periods, and the rest as a share of one.
        least_thrust, largest_thrust: [m/s^2] bounds of the thrust that is commanded; the second grows where effectiveness is lost.
        thrust_limit: [m/s^2] that the controller plans with.
    """

    nodes: int
    sweeps: int
    node_parts: int
    stop_early: bool
    period: float
    rotors: int
    steps: int
    plant_step: float
    table_period: float
    lead: float
    predicted_periods: int
    predicted_rest: float
    feed_forward: bool
    gravity: float
    segment_switch: int
    segment_switch_distance: float
    thrust_noise: float
    rate_noise: float
    noise_memory: float
    thrust_bias: float
    position: float
    velocity: float
    attitude: float
    measured_position: float
    measured_velocity: float
    measured_attitude: float
    wind: float
    wind_memory: float
    steady_wind: float
    sagging: bool
    duration: float
    offset_free: bool
    corrected: bool
    acted_periods: int
    acted_rest: float
    least_thrust: float
    largest_thrust: float
    thrust_limit: float


class Job(NamedTuple):
    """A batch of B flights over S segments, as plain arrays.

    Attributes:
        table: (rows, 14) reference: p q v, thrust per mass, rates; its kind of float is that of the flights.
        row_pieces: (rows,) piece at each row.
        piece_segments: (P,) segment that each piece belongs to.
        piece_points: (P, 3) [m] where each piece begins.
        parameters: (B, S, K) as the controller computes with them; see `registry.ControllerFunctions.parameters_of`.
        seeds: (B,).
        input_weights: (4,) R.
        low, high: (4,) bounds of the inputs.
        vehicles: (B or 1, V) as `plants.plant_numbers` gives them.
        delay_periods, delay_steps: (B or 1,) dead time in control periods and, beyond them, in steps of the plant.
        sags: (B or 1, 2) share of thrust lost over the reference's duration, and in a second for each N^1.5 of thrust.
        autopilot: (A,).
        control_model: (M,) in the order of `parameter_layout.MODEL`.
        known_drag: (M,) the same with the drags that `observer` corrects for, else zeros.
        observer: (G,) as `observer.observer_numbers` gives them.
        log_rows: (B,) row in `logs`, -1 for a flight that is not logged.
        logs: (L, periods + 1, 21 + rotors).
        queue: (1,) next flight that nobody flies yet.
    """

    table: Any
    row_pieces: Any
    piece_segments: Any
    piece_points: Any
    parameters: Any
    seeds: Any
    input_weights: Any
    low: Any
    high: Any
    vehicles: Any
    delay_periods: Any
    delay_steps: Any
    sags: Any
    autopilot: Any
    control_model: Any
    known_drag: Any
    observer: Any
    log_rows: Any
    logs: Any
    queue: Any
