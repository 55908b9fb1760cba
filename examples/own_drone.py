"""A drone of your own: a dozen lines of TOML, its margins, and a controller tuned for it."""

from pathlib import Path

import hotlap
from hotlap.feasibility import describe

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
race = hotlap.load_race("my-race.toml")
for finding in describe(race):
    print(f"{finding.label:<20} {finding.value:<20} {finding.remark}")

print(hotlap.tune(race, validation=100, out="runs/my-drone"))
