"""A program that simulates a drone: a line of JSON with what to do comes in, one with the state goes out. It may misbehave.

Arguments: `well`, or how it ends (`dies`, `hangs`, `babbles`, `shortens`, `bends`), and after how many answers. Its drone does at once
what it is told: thrust along its axis, and body rates.
"""

import json
import math
import sys
import time

STEP = 0.0025  # s
GRAVITY = 9.81


def move(state: list[float], command: list[float]) -> list[float]:
    """The state a step later."""
    p, (w, x, y, z), v, (thrust, *rates) = state[:3], state[3:7], state[7:10], command
    a, b, c = (STEP / 2 * rate for rate in rates)
    q = [w - x * a - y * b - z * c, x + w * a + y * c - z * b, y + w * b + z * a - x * c, z + w * c + x * b - y * a]
    size = math.sqrt(sum(part * part for part in q))
    axis = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    push = [thrust * axis[0], thrust * axis[1], thrust * axis[2] - GRAVITY]
    p = [place + STEP * speed + STEP**2 / 2 * one for place, speed, one in zip(p, v, push, strict=True)]
    return [*p, *(part / size for part in q), *(speed + STEP * one for speed, one in zip(v, push, strict=True)), *rates]


def main() -> None:
    """Serve until nobody asks any more."""
    manner, state = sys.argv[1], [0.0] * 13
    last = int(sys.argv[2]) if manner != "well" else math.inf
    for answers, line in enumerate(sys.stdin, 1):
        asked = json.loads(line)
        if "state" in asked:
            state = asked["state"]
        for _ in range(asked.get("steps", 0)):
            state = move(state, asked["command"])
        if answers > last:
            if manner == "dies":
                sys.exit(3)
            if manner == "hangs":
                time.sleep(3600)
            if manner == "shortens":
                state = state[:7]
            if manner == "bends":
                state = [0.0] * 13
        sys.stdout.write("garbage\n" if manner == "babbles" and answers > last else f"{json.dumps(state)}\n")
        sys.stdout.flush()


main()
