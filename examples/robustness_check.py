"""Will it hold? Tuned parameters flown with another mass and another dead time than they were tuned for."""

import numpy as np

from hotlap import BuiltIn, Goal, Objective, Tuning, TuningSettings, prepare, tune, tuners
from hotlap.analysis.hold import will_it_hold
from hotlap.scoring import score
from hotlap.truth import MASSES, TRUTH, scale, truth_of

course, world = prepare("drop-20"), BuiltIn()
*_, last = tune(Objective(course, world), Tuning(tuners.build("gatewise"), course, TuningSettings(validation=100)))
for hold in will_it_hold(course, world, Goal(), last.best.parameters, seed=0):
    print(f"{hold.change:<22} {hold.validation.successes:3} of {hold.validation.flights}")

masses, delays, each = (0.9, 1.0, 1.1), (0.03, 0.045, 0.06), 50
nominal = truth_of(course.race.vehicle)
truths = []
for mass in masses:
    for delay in delays:
        truth = scale(nominal, MASSES, mass)
        truth[TRUTH.index("delay")] = delay
        truths += [truth] * each
flown = world.fly(
    course,
    np.repeat(last.best.parameters[None], len(truths), axis=0),
    np.tile(np.arange(each), len(masses) * len(delays)),
    truth=np.array(truths),
)
complete = score(flown, course.race.judge).complete.reshape(len(masses), len(delays), each).mean(axis=2)
print("\nshare of complete flights; dead time " + "  ".join(f"{delay * 1e3:g} ms" for delay in delays))
for mass, row in zip(masses, complete, strict=True):
    print(f"  mass x {mass:<4} " + "  ".join(f"{share:5.0%}" for share in row))
