"""A track of your own: gates in order, planned in minimum time, flown and tuned."""

import numpy as np

import hotlap
from hotlap import tuners
from hotlap.planning.preparation import prepare
from hotlap.race.track import Gate, Track
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds import BuiltIn

turns = np.linspace(0, 2 * np.pi, 9)[1:]
gates = np.stack([9 * np.sin(turns), 9 - 9 * np.cos(turns), 1.5 + np.sin(2 * turns)], axis=1).round(2)
track = Track(
    name="bowl",
    start=(0.0, 0.0, 1.5),
    gates=tuple(Gate(position=(x, y, z)) for x, y, z in gates.tolist()),
    end=(4.0, 0.0, 2.0),  # where the plan ends, after the last gate; it does not count as a gate
    floor=0.0,
)
race = hotlap.load_race("circle-34").model_copy(update={"name": "bowl", "track": track})

scenario = prepare(race)
reference = scenario.reference
print(f"planned: {reference.lap_time:.2f} s, up to {reference.max_speed:.1f} m/s; segments: {', '.join(scenario.segments.classes)}")
run = Tuning(tuners.build("gate_gp"), scenario, TuningSettings(budget=200, validation=100))
for batch in tune(Objective(scenario, BuiltIn()), run):
    if batch.done:
        print(f"confirmed: {batch.best.confirmed}, after {batch.search_flights} search flights; lap {batch.best.lap_time:.2f} s")
        print(batch.best.parameters.round(1))
