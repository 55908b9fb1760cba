"""Moves: commands of one vehicle, in the order that the server survives.

The server works on one move at a time: a new one cancels the one before, whose call then returns false; a move that ran out returns
true. While the simulation is paused, a move that is replaced can miss that it is cancelled; with further moves behind it the server
stops for good. So the reply to the move before is waited for at every move, and where it does not come, `cancelLastTask` calls it off.
"""

from __future__ import annotations

from collections.abc import Sequence

from hotlap.worlds.airsim.client import Client

CANCEL_AFTER = 0.3  # s without the reply to a move that was replaced
SETTLED = 0.05  # s after which a move that was cancelled by mistake has said so
TRIES = 3
LEAST_TIME = 0.2  # s of simulated time that a move lasts; 60 ms behind its end the vehicle holds its position


class Moves:
    """Sends one vehicle's moves.

    Args:
        client: connection.
        vehicle: its name; "": the only one.
    """

    def __init__(self, client: Client, vehicle: str) -> None:
        self._client, self._vehicle = client, vehicle
        self._present: int | None = None  # the move whose reply has not been seen

    def send(self, rates: Sequence[float], throttle: float, duration: float) -> None:
        """Command body rates and throttle from now on.

        Args:
            rates: [rad/s] (body, ours).
            throttle: 0 to 1.
            duration: [s] of simulated time in which no other move is sent.

        Raises:
            SimulatorError: the server does not take it.
        """
        p, q, r = (float(rate) for rate in rates)
        for _ in range(TRIES):
            before, arguments = self._present, (p, -q, -r, float(throttle), LEAST_TIME + duration, self._vehicle)
            self._present = self._client.send("moveByAngleRatesThrottle", *arguments)
            if before is None or not self._call_off(before) or not self._client.has_replied(self._present, SETTLED):
                return
            self._end(self._present)
            self._present = None
        raise self._client.fault(f"moveByAngleRatesThrottle was called off {TRIES} times: does another program fly this vehicle?")

    def stop(self) -> None:
        """Call off the present move."""
        if self._present is not None:
            self._client.call("cancelLastTask", self._vehicle)
            self._end(self._present)
            self._present = None

    def _call_off(self, move: int) -> bool:
        """See a replaced move to its end; returns whether it had to be cancelled, which may have hit its successor."""
        missed = not self._client.has_replied(move, CANCEL_AFTER)
        if missed:
            self._client.call("cancelLastTask", self._vehicle)
        self._end(move)
        return missed

    def _end(self, move: int) -> None:
        """Take the reply of a move that is over."""
        ran_out = self._client.reply(move)
        if not isinstance(ran_out, bool):
            raise self._client.fault(f"moveByAngleRatesThrottle returned {ran_out!r:.40}, not whether the move ran out")
