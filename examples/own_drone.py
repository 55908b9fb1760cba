"""A drone of your own: a dozen lines of TOML, its margins, and a controller tuned for it."""

from pathlib import Path

from hotlap import BuiltIn, Objective, Tuning, TuningSettings, load_race, prepare, tune, tuners
from hotlap.planning.feasibility import describe

DRONE = """
mass = 0.85                       # kg
inertia = [1e-3, 1e-3, 1.7e-3]    # kg m^2
arm = 0.15                        # m
rotor_thrust = [0.0, 6.9]         # N a rotor
torque_ratio = 0.05               # m
drag = [0.3, 0.3, 0.1]            # 1/s
delay = 0.05                      # s, from command to rotors
"""
RACE = """
track = "circle"
vehicle = "my-drone.toml"
model = { base = "my-drone.toml", delay = 0.0 }    # the delay is not in the controller's model
[planning]
quadrotor = "airsim-plan"
v_max = 34.0
"""

Path("my-drone.toml").write_text(DRONE, encoding="utf-8")
Path("my-race.toml").write_text(RACE, encoding="utf-8")
race = load_race("my-race.toml")
for finding in describe(race):
    print(f"{finding.label:<20} {finding.value:<20} {finding.remark}")

scenario = prepare(race)
*_, last = tune(Objective(scenario, BuiltIn()), Tuning(tuners.build("gate_gp"), scenario, TuningSettings(validation=100)))
print(f"confirmed: {last.best.confirmed}, after {last.search_flights} search flights; lap {last.best.lap_time:.2f} s")
