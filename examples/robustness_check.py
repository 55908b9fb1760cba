"""Robustness: tuned parameters flown with another mass and another dead time than they were tuned for."""

import numpy as np

from hotlap import tuners
from hotlap.analysis.robustness import check_robustness
from hotlap.planning.preparation import prepare
from hotlap.race.vehicle_parameters import MASSES, VEHICLE_PARAMETERS, scale, vehicle_parameters_of
from hotlap.tuning.goal import Goal
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import score
from hotlap.worlds import BuiltIn

scenario, world = prepare("drop-20"), BuiltIn()
*_, last = tune(Objective(scenario, world), Tuning(tuners.build("gate_gp"), scenario, TuningSettings(validation=100)))
for hold in check_robustness(scenario, world, Goal(), last.best.parameters, seed=0):
    print(f"{hold.change:<22} {hold.validation.successes:3} of {hold.validation.flights}")

masses, delays, each = (0.9, 1.0, 1.1), (0.03, 0.045, 0.06), 50
nominal = vehicle_parameters_of(scenario.race.vehicle)
vehicles = []
for mass in masses:
    for delay in delays:
        vehicle_parameters = scale(nominal, MASSES, mass)
        vehicle_parameters[VEHICLE_PARAMETERS.index("delay")] = delay
        vehicles += [vehicle_parameters] * each
flown = world.fly(
    scenario,
    np.repeat(last.best.parameters[None], len(vehicles), axis=0),
    np.tile(np.arange(each), len(masses) * len(delays)),
    vehicle_parameters=np.array(vehicles),
)
complete = score(flown, scenario.race.judge).complete.reshape(len(masses), len(delays), each).mean(axis=2)
print("\nshare of complete flights; dead time " + "  ".join(f"{delay * 1e3:g} ms" for delay in delays))
for mass, row in zip(masses, complete, strict=True):
    print(f"  mass x {mass:<4} " + "  ".join(f"{share:5.0%}" for share in row))
