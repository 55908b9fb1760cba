"""From a race to a tuned, validated controller and a page about it; run again, it goes on where it stopped."""

import hotlap

tuned = hotlap.tune("circle-34", out="runs/quickstart")
print(tuned)
for name, value in zip(tuned.scenario.space.names, tuned.values[0], strict=True):
    print(f"  {name:<12} {value:.1f}")
