"""Status: what the supervisor of a Crazyflie says, `supervisor.info`."""

from __future__ import annotations

from enum import IntFlag


class Status(IntFlag):
    """Its bits.

    CAN_ARM: checks before the flight are passed. ARMED: motors may turn. AUTO_ARMED: it arms by itself, as every one with brushed motors.
    CAN_FLY, FLYING: as it says. TUMBLED, LOCKED, CRASHED: it does not fly any more; when it is locked it has to be restarted. COMMANDER:
    its high-level commander flies it.
    """

    CAN_ARM = 1 << 0
    ARMED = 1 << 1
    AUTO_ARMED = 1 << 2
    CAN_FLY = 1 << 3
    FLYING = 1 << 4
    TUMBLED = 1 << 5
    LOCKED = 1 << 6
    CRASHED = 1 << 7
    COMMANDER = 1 << 8


DOWN = Status.TUMBLED | Status.LOCKED | Status.CRASHED
WORDS = {
    Status.TUMBLED: "it has tumbled",
    Status.LOCKED: "it is locked, and has to be restarted",
    Status.CRASHED: "it has crashed",
}


def complaint(status: Status) -> str:
    """What is wrong with it, in words; "" where nothing is."""
    return ", ".join(words for bit, words in WORDS.items() if bit in status)
