"""From a race to a tuned, validated controller: every flight is recorded, and run again it goes on where it stopped."""

from hotlap import BuiltIn, Configuration, Metric, Objective, Study, TuningSettings, prepare

scenario = prepare("circle-34")  # plans the fastest flight through the gates, or finds the plan in the cache
first_guess = scenario.space.first_guess(len(scenario.segments))  # the controller's default; (segments, parameters)
settings = TuningSettings(budget=200, seed=0, confirm=10)
asked = Configuration(scenario, "built-in", Metric.TIME, "gate_gp:default", settings, first_guess)

with Study.open("runs/quickstart", asked) as study:
    result = study.run(Objective(scenario, BuiltIn()))

print(f"{result.race}: confirmed: {result.best.confirmed}, after {result.search_flights} search flights, {result.flights} in all")
if result.validation is not None:
    print(f"passes every gate in {result.validation.successes} of {result.validation.flights} flights with fresh noise")
for name, value in zip(scenario.space.names, result.best.parameters[0], strict=True):
    print(f"  {name:<12} {value:.1f}")
