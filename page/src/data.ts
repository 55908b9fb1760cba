/** Data: the document of a study, as `report/page/document.py` writes it. SI units; world frame x forward, y left, z up. */

import type { Table } from "./table";

export interface Interval {
  readonly flights: number;
  readonly successes: number;
  readonly rate: number;
  readonly low: number;
  readonly high: number;
}

/** What the figures of the tuned parameters are means over. */
export interface Kept {
  readonly flights: number;
  readonly cost: number | null;
  /** Flights that chose among candidates where the search confirmed none. */
  readonly selection_flights: number;
}

export interface Headline {
  readonly race: string;
  readonly vehicle: string;
  readonly model: string;
  readonly latency_unknown: number | null;
  readonly mistaken?: readonly string[];
  readonly tuner: string;
  readonly goal: string;
  readonly seed: number;
  readonly first_guess: string;
  readonly state: "finished" | "running";
  readonly flights: number;
  readonly search_flights: number;
  readonly budget: number;
  readonly lap_time: number | null;
  readonly planned_lap_time: number | null;
  readonly completion: number | null;
  readonly confirmed: boolean;
  readonly confirm: number;
  readonly kept?: Kept;
  /** That the search kept what it began with, in words; pages of before do not say. */
  readonly kept_guess?: string | null;
  readonly validation: Interval | null;
  readonly wall_time: number | null;
  readonly remark: string;
}

export interface Piece {
  readonly class: string;
  readonly start: number;
  readonly end: number;
  readonly segment: number;
}

export interface Reference {
  readonly time: Table;
  readonly position: Table;
  readonly attitude: Table;
  readonly speed: Table;
  readonly thrust: Table;
  readonly rates: Table;
}

/** A gate that is more than a point; lines relative to its centre. */
export interface GateShape {
  /** Which of the gates that have to be passed it is; several times where there are laps. */
  readonly gates: readonly number[];
  readonly centre: readonly number[];
  /** The opening's rim, at both ends of a tunnel; none for a ball. */
  readonly rims: readonly Table[];
  /** The outer rims of the frame. */
  readonly frames: readonly Table[];
  /** Lines along a tunnel. */
  readonly walls: readonly Table[];
  /** The way in which it is passed; null where both ways count. */
  readonly normal: readonly number[] | null;
  /** Length of a tunnel. */
  readonly depth: number;
  readonly reach: number;
  readonly bottom: number;
  readonly top: number;
}

export interface Pole {
  readonly position: readonly [number, number];
  readonly radius: number;
  readonly top: number | null;
  readonly bottom: number | null;
}

export interface Sphere {
  readonly position: readonly [number, number, number];
  readonly radius: number;
}

export interface Box {
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

export interface Scenario {
  readonly duration: number;
  readonly lap_time: number;
  readonly gate_distance: number;
  readonly rule: "clock" | "approach" | "opening";
  readonly floor: number | null;
  readonly ceiling: number | null;
  readonly gate_shapes: readonly GateShape[];
  /** Points that are planned through and do not count. */
  readonly points: Table;
  readonly poles: readonly Pole[];
  readonly spheres: readonly Sphere[];
  readonly boxes: readonly Box[];
  readonly box: Box | null;
  /** Least and largest coordinates of the plan with what stands on the track; null where there are bare points alone. */
  readonly bounds: readonly [readonly number[], readonly number[]] | null;
  readonly gates: Table;
  /** By which they are called, from 1 in each lap. */
  readonly gate_numbers: readonly number[];
  readonly gate_times: Table;
  readonly gate_segments: readonly number[];
  readonly pieces: readonly Piece[];
  readonly segment_names: readonly string[];
  readonly reference: Reference;
  readonly limits: { readonly thrust: readonly number[]; readonly rates: readonly number[]; readonly rotor_thrust: readonly number[] };
  /** [x, y] of each rotor relative to the centre of mass, body frame. */
  readonly rotors: readonly (readonly [number, number])[];
}

export interface EffortNumbers {
  readonly thrust_activity: number | null;
  readonly rate_activity: number | null;
  readonly saturated: number | null;
  readonly oscillation: { readonly frequency: number | null; readonly share: number | null } | null;
}

export interface Effort extends EffortNumbers {
  readonly reference: EffortNumbers | null;
}

/** Spectra and step responses of the body rates, each table with a column for each axis. */
export interface Response {
  /** [Hz] */
  readonly frequencies: Table;
  /** [(rad/s)²/Hz] of the commands, and of the rates themselves. */
  readonly commanded: Table;
  readonly measured: Table;
  /** [s] */
  readonly lags: Table;
  /** Rate after a unit step of its command, and its standard deviation; NaN where it cannot be told. */
  readonly steps: Table;
  readonly deviations: Table;
  /** Share of the power of the rate that past commands explain. */
  readonly explained: Table;
}

export interface Trace {
  readonly id: string;
  readonly label: string;
  readonly ending: string;
  readonly failed: boolean;
  readonly seed: number;
  readonly lap_time: number | null;
  readonly end_time: number | null;
  readonly end_position: readonly (number | null)[];
  readonly time: Table;
  readonly position: Table;
  readonly attitude: Table;
  readonly speed: Table;
  readonly error: Table;
  readonly rates: Table;
  readonly rotor_thrusts: Table;
  readonly command_thrust: Table;
  readonly command_rates: Table;
  /** What the controller estimates of the vehicle, where it does. */
  readonly thrust_effectiveness: Table | null;
  readonly disturbance: Table | null;
  readonly gate_distance: Table;
  readonly seen_times: Table;
  readonly effort: Effort | null;
  readonly response?: Response | null;
}

export interface Repeat {
  readonly id: string;
  readonly label: string;
  readonly flights: number;
  readonly complete: number;
  readonly low: number;
  readonly high: number;
  readonly failures: Table;
  readonly failed_gates: readonly number[];
  readonly ends: readonly string[];
}

export interface Flights {
  readonly number: Table;
  readonly cost: Table;
  readonly completion: Table;
  readonly mean_error: Table;
  readonly lap_time: Table;
  readonly stream: ArrayLike<number>;
  readonly accepted: ArrayLike<number>;
  readonly succeeded: ArrayLike<number>;
  /** Whether the flight was with the parameters that are the result. */
  readonly tuned: ArrayLike<number>;
  /** Whether the tuner is a chain, so that what it accepts says where it goes on from. */
  readonly chain: boolean;
  /** What is said of flights that passed and that failed. */
  readonly verdicts: readonly [string, string];
  readonly failed_segment: ArrayLike<number>;
  readonly cost_name: string;
}

export interface ParameterSet {
  readonly names: readonly string[];
  readonly symbols: readonly string[];
  readonly units: readonly string[];
  readonly low: Table;
  readonly high: Table;
  readonly default: Table;
  readonly first: Table;
  readonly best: Table;
}

export interface Samples {
  readonly parameters: Table;
  readonly accepted: ArrayLike<number>;
  readonly completion: Table;
  readonly succeeded: ArrayLike<number>;
  readonly chain: boolean;
  readonly verdicts: readonly [string, string];
  readonly of: number;
}

export interface Sensitivity {
  readonly factors: readonly number[];
  readonly flights: number;
  readonly completion: Table;
  readonly complete: Table;
  readonly by_segment: Table;
  readonly cost_name?: string;
  readonly cost?: Table;
  readonly cost_by_segment?: Table;
  /** Whether completion is the same whatever is changed; whether the cost is shown in its place, over factors and in segments. */
  readonly flat: boolean;
  readonly cost_tells: boolean;
  readonly cost_tells_by_segment: boolean;
}

/** What is left of thrust and body rates over what the plan needs, where that is least. */
export interface Margin {
  readonly thrust: number;
  readonly rates: number;
  readonly place: string;
}

/** Why flights fail, and what to do about it; `tried`: flights without the cause. */
export interface Cause {
  readonly cause: string;
  readonly found: string;
  readonly advice: string;
  readonly tried: { readonly flights: number; readonly successes: number } | null;
  readonly supposed: string;
  /** How many flights without the cause passed the gate where most had failed, if many more than before; pages of before do not say. */
  readonly passed?: number;
  readonly gate?: string;
  /** How many of the same flights met the goal with the cause. */
  readonly before?: number;
}

export interface Robustness extends Interval {
  readonly margin: Margin | null;
  readonly causes: readonly Cause[];
  readonly change: string;
  /** Whether somebody asked for this condition; pages of before do not say. */
  readonly asked?: boolean;
}

export interface Configuration {
  readonly command: string;
  readonly fingerprint: string;
  readonly versions: Readonly<Record<string, string>>;
  readonly opened: readonly string[];
  readonly race_toml: string;
  readonly parameters_toml?: string;
  readonly settings: Readonly<Record<string, unknown>>;
  readonly world: string;
  readonly files: Readonly<Record<string, string>>;
}

export interface Study {
  readonly format: number;
  readonly kind: string;
  readonly live: boolean;
  readonly headline: Headline;
  readonly scenario: Scenario;
  readonly traces: readonly Trace[];
  readonly repeats: readonly Repeat[];
  readonly flights: Flights | null;
  readonly parameters: ParameterSet | null;
  readonly samples: Samples | null;
  readonly sensitivity: Sensitivity | null;
  readonly robustness: readonly Robustness[];
  /** What to try where flights fail, each thing once. */
  readonly advice: readonly string[];
  readonly configuration: Configuration | null;
}

export type Part = keyof Study;
