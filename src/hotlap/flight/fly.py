"""Fly a batch of flights: from a scenario, parameters and seeds to a record of what happened."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights, Log
from hotlap.flight.job import LOG_COLUMNS, Job, Settings
from hotlap.flight.judge import Gates, Verdicts, gates_of, new_verdicts
from hotlap.flight.kernel import fly_queue
from hotlap.flight.line_search import LONGEST_PART
from hotlap.flight.numbers import Numbers
from hotlap.flight.observer import drag_free, known_drag, observer_numbers
from hotlap.flight.plant import model_numbers
from hotlap.flight.plants import allocator, plant_numbers
from hotlap.flight.registry import CONTROLLERS
from hotlap.flight.segment_switch import switch_number
from hotlap.race.plant_kind import plant_kind_of
from hotlap.race.race import PLANT_STEP, ReferenceTime
from hotlap.race.vehicle_parameters import part_of, vehicle_parameters_of
from hotlap.reference.scenario import Scenario
from hotlap.system.processors import available

Floats = NDArray[np.float64]

AFTERWARDS = 0.1  # s: room of a log after the last gate is decided


@dataclass(frozen=True)
class Effort:
    """Control steps that were computed: in all lanes, and in those that had a flight to fly."""

    lane_steps: int
    useful_steps: int

    @property
    def useful_share(self) -> float:
        """Share of the control steps that a flight needed, 0 to 1."""
        return self.useful_steps / self.lane_steps if self.lane_steps else 1.0


def fly_batch(
    scenario: Scenario,
    parameters: Parameters,
    seeds: NDArray[np.int64],
    *,
    numbers: Numbers,
    threads: int = 0,
    vehicle_parameters: Floats | None = None,
    log: Sequence[int] = (),
) -> tuple[Flights, Effort]:
    """Fly each row of a batch once; the result of a flight does not depend on the other rows.

    It depends on scenario, parameters, seed, vehicle parameters and the kind of number, alone.

    Args:
        scenario: what is flown.
        parameters: shape (B, S, K), of each flight and segment in the order of the scenario's parameter space.
        seeds: shape (B,), of the noise.
        numbers: kind of number to compute in.
        threads: how many; 0 for one a processor.
        vehicle_parameters: shape (B, P), the vehicle of each flight, in the columns of `vehicle_parameters.VEHICLE_PARAMETERS`.
        log: indices in the batch of the flights to record in full.

    Raises:
        HotlapError: arrays that do not fit together, or parameters that are not positive.
    """
    job, gates = prepare(scenario, parameters, seeds, numbers, vehicle_parameters, log)
    verdicts = new_verdicts(len(seeds), len(gates.times))
    settings, law = settings_of(scenario)._replace(sagging=bool(job.sags.any())), scenario.race.controller.law
    plant, allocate = plant_kind_of(scenario.race.vehicle), allocator(scenario.race.vehicle)
    crew = min(threads or available(), -(-len(seeds) // numbers.lanes))
    if crew <= 1:
        effort = fly_queue(numbers, law, plant, allocate, job, settings, gates, verdicts)
    else:
        with ThreadPoolExecutor(crew) as pool:  # compiled code runs without the interpreter's lock
            effort = sum(pool.map(lambda _: fly_queue(numbers, law, plant, allocate, job, settings, gates, verdicts), range(crew)))
    lane_steps, useful_steps = np.asarray(effort).tolist()
    return record(scenario, job, gates, verdicts, log), Effort(lane_steps, useful_steps)


def settings_of(scenario: Scenario) -> Settings:
    """The settings that all flights over a scenario share, as plain numbers."""
    race = scenario.race
    controller, noise, control_model = race.controller, race.noise, race.control_model
    lead, (least, most) = race.prediction, scenario.thrust_limits
    settings = Settings(
        nodes=controller.nodes,
        sweeps=controller.sweeps,
        node_parts=max(1, math.ceil(controller.widest_spacing / LONGEST_PART - 1e-9)),
        stop_early=True,
        period=controller.period,
        rotors=race.vehicle.rotor_count,
        steps=round(controller.period / PLANT_STEP),
        plant_step=PLANT_STEP,
        table_period=scenario.reference.period,
        lead=lead if controller.reference_time is ReferenceTime.EXECUTION else 0.0,
        predicted_periods=0,
        predicted_rest=0.0,
        feed_forward=controller.feed_forward,
        gravity=control_model.gravity,
        segment_switch=switch_number(controller.segment_switch),
        segment_switch_distance=controller.segment_switch_distance,
        thrust_noise=noise.thrust,
        rate_noise=noise.rates,
        noise_memory=_memory(controller.period, noise.time),
        thrust_bias=noise.thrust_bias,
        position=noise.position,
        velocity=noise.velocity,
        attitude=noise.attitude,
        measured_position=noise.measured_position,
        measured_velocity=noise.measured_velocity,
        measured_attitude=noise.measured_attitude,
        wind=noise.wind,
        wind_memory=_memory(controller.period, noise.wind_time),
        steady_wind=noise.steady_wind,
        sagging=False,
        duration=scenario.reference.duration,
        offset_free=scenario.offset_free,
        corrected=scenario.corrects_target,
        acted_periods=0,
        acted_rest=0.0,
        least_thrust=least,
        largest_thrust=most,
        thrust_limit=controller.thrust[1],
    )
    return acting(predicting(settings, lead), control_model.delay)


def predicting(settings: Settings, span: float) -> Settings:
    """The same settings, but the state is predicted over a time span [s]."""
    periods = math.floor(span / settings.period + 1e-9)
    rest = span - periods * settings.period
    return settings._replace(predicted_periods=periods, predicted_rest=rest if rest > 1e-9 else 0.0)


def acting(settings: Settings, dead_time: float) -> Settings:
    """The same settings, but the observer takes the thrust that was commanded a dead time [s] ago."""
    place = dead_time / settings.period
    periods = math.floor(place + 1e-9)
    return settings._replace(acted_periods=periods, acted_rest=place - periods if place - periods > 1e-9 else 0.0)


def prepare(
    scenario: Scenario,
    parameters: Parameters,
    seeds: NDArray[np.int64],
    numbers: Numbers,
    vehicle_parameters: Floats | None,
    log: Sequence[int],
) -> tuple[Job, Gates]:
    """A batch as plain arrays, and its gates, as compiled code takes them; arguments as for `fly_batch`."""
    race, reference, controller = scenario.race, scenario.reference, scenario.race.controller
    _check(scenario, parameters, seeds, vehicle_parameters, log)
    gates = gates_of(race.judge, race.track, race.vehicle.outer_radius, reference)
    given = vehicle_parameters_of(race.vehicle)[None] if vehicle_parameters is None else np.asarray(vehicle_parameters, dtype=np.float64)
    vehicles, autopilot = plant_numbers(given, race.vehicle, race.control_model)
    delay_steps = np.rint(part_of(given, "delay")[:, 0] / PLANT_STEP).astype(np.int64)
    in_period = round(controller.period / PLANT_STEP)
    log_rows = np.full(len(seeds), -1, dtype=np.int64)
    log_rows[list(log)] = np.arange(len(log))
    last = reference.gate_times[-1] + (race.judge.window[1] if len(log) else 0.0) + AFTERWARDS
    thrust, tilt, yaw = controller.input_weights
    table = drag_free(reference, race.control_model.gravity) if scenario.corrects_target else reference.table
    model = model_numbers(race.control_model)
    job = Job(
        table=np.ascontiguousarray(table, dtype=numbers.dtype),
        row_pieces=scenario.segments.piece_at(reference.times),
        piece_segments=np.array([piece.segment for piece in scenario.segments.pieces]),
        piece_points=np.ascontiguousarray(reference.position_at(scenario.segments.starts)),
        parameters=CONTROLLERS[controller.law].parameters_of(controller, parameters),
        seeds=np.ascontiguousarray(seeds, dtype=np.int64),
        input_weights=np.array([thrust, tilt, tilt, yaw]),
        low=np.array([controller.thrust[0], *(-rate for rate in controller.rates)]),
        high=np.array([controller.thrust[1], *controller.rates]),
        vehicles=vehicles,
        delay_periods=delay_steps // in_period,
        delay_steps=delay_steps % in_period,
        sags=np.hstack([part_of(given, "sag"), part_of(given, "charge_sag")]),
        autopilot=autopilot,
        control_model=model,
        known_drag=known_drag(race, model),
        observer=observer_numbers(race),
        log_rows=log_rows,
        logs=np.zeros((len(log), math.ceil(last / controller.period) + 2, LOG_COLUMNS + race.vehicle.rotor_count)),
        queue=np.zeros(1, dtype=np.int64),
    )
    return job, gates


def _check(
    scenario: Scenario, parameters: Parameters, seeds: NDArray[np.int64], vehicle_parameters: Floats | None, log: Sequence[int]
) -> None:
    """Refuse arrays that do not fit together: compiled code does not check."""
    wanted = (len(seeds), len(scenario.segments), scenario.space.size)
    if parameters.shape != wanted:
        raise HotlapError(f"parameters must have shape (flights, segments, parameters) = {wanted}, not {parameters.shape}")
    if not (np.isfinite(parameters) & (parameters > 0)).all():
        raise HotlapError("parameters must be finite and positive")
    if len(seeds) and (seeds.min() < 0 or seeds.max() >= 2**53):
        raise HotlapError("seeds must not be negative, and stay below 2^53")
    if vehicle_parameters is not None and len(vehicle_parameters) != len(seeds):
        raise HotlapError(f"vehicle_parameters must have a row for each of {len(seeds)} flights, not {len(vehicle_parameters)}")
    if len(set(log)) != len(log) or any(not 0 <= i < len(seeds) for i in log):
        raise HotlapError(f"log must name flights of the batch, each once: 0 to {len(seeds) - 1}")


def _memory(period: float, time: float) -> float:
    """Factor by which correlated noise decays in one period."""
    return math.exp(-period / time) if time > 0 else 0.0


def record(scenario: Scenario, job: Job, gates: Gates, v: Verdicts, log: Sequence[int]) -> Flights:
    """The record of the flights: the judge's results, and the logs."""
    return Flights(
        seeds=job.seeds,
        gates_passed=v.gates_passed,
        end=v.end,
        cause=v.cause,
        cause_index=v.cause_index,
        end_time=v.end_time,
        end_position=v.end_position,
        lap_time=v.lap_time,
        clock_distance=v.clock_distance,
        closest_distance=v.closest_distance,
        closest_time=v.closest_time,
        rim_distance=v.rim_distance,
        mean_error=v.mean_error,
        max_error=v.max_error,
        rooms=gates.openings.rooms if len(gates.openings.rooms) else np.full(len(gates.times), gates.distance),
        gate_positions=gates.positions,
        gate_times=gates.times,
        gate_segments=scenario.gate_segments,
        logs={i: _log(job.logs[k, : v.ticks[i] + 1], scenario.race.controller.period) for k, i in enumerate(log)},
    )


def _log(rows: Any, period: float) -> Log:
    """One flight's log."""
    times = np.arange(len(rows), dtype=np.float64) * period
    states, commands, estimates, rotor_thrusts = np.split(rows, (13, 17, 21), axis=1)
    return Log(times, states.copy(), rotor_thrusts.copy(), commands.copy(), estimates.copy())
