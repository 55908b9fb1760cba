"""From a race to a tuned, validated controller: every flight is recorded, and run again it goes on where it stopped."""

from hotlap import BuiltIn, Configuration, Metric, Objective, Study, TuningSettings, carry_out, prepare

course = prepare("circle-34")  # plans the fastest flight through the gates, or finds the plan in the cache
first_guess = course.space.first_guess(len(course.segments))  # the controller's default; (segments, parameters)
settings = TuningSettings(budget=200, seed=0, confirm=10)
asked = Configuration(course, "built-in", Metric.TIME, "gatewise:default", settings, first_guess)

with Study.open("runs/quickstart", asked) as study:
    result = carry_out(study, Objective(course, BuiltIn()))

print(f"{result.race}: confirmed: {result.best.confirmed}, after {result.search_flights} search flights, {result.flights} in all")
if result.validation is not None:
    print(f"passes every gate in {result.validation.successes} of {result.validation.flights} flights with fresh noise")
for name, value in zip(course.space.names, result.best.parameters[0], strict=True):
    print(f"  {name:<12} {value:.1f}")
