"""Log frame: when the flight of a log began, and how its frame lies in that of the race."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.core.shown import Shown
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.hotlap_csv import KIND as OWN
from hotlap.reference.scenario import Scenario

STEP = 0.02  # s between the points that are laid over each other
COARSE, FINE = 0.05, 0.002  # s between starts that are tried
LEAST_SHARE = 0.5  # of the lap that a start must leave room for
REACH = 4.0  # m from the start, beyond which a drone has left it, or half as far as the race goes
WAIT, STILL = 0.5, 0.15  # s before the start within which a drone that waits moves by less [m]
TURN = 0.4  # rad to both sides, within which the turn of the path is looked for
TINY = 1e-9  # m
POOR = 0.5  # of the spread of the reference: who leaves more has flown something else


@dataclass(frozen=True, repr=False)
class LogFrame(Shown):
    """Where a log lies in the race.

    Attributes:
        start: [s] of the log's clock at which the race begins.
        yaw: [rad] by which the log is turned, about z.
        shift: shape (3,) [m] by which it is moved then.
        residual: [m] root mean square distance of the paths that a fit has left; NaN where nothing was fitted.
        words: how it was found.
    """

    start: float
    yaw: float
    shift: Floats
    residual: float
    words: str

    def points(self, points: Floats) -> Floats:
        """Points of the log, shape (n, 3), in the race's frame."""
        return self.vectors(points) + self.shift

    def vectors(self, vectors: Floats) -> Floats:
        """Vectors of the log's world, shape (n, 3), in the race's frame."""
        if not self.yaw:
            return vectors
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return vectors @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def attitudes(self, attitudes: Floats) -> Floats:
        """Attitudes, shape (n, 4), in the race's frame."""
        if not self.yaw:
            return attitudes
        c, s = math.cos(self.yaw / 2), math.sin(self.yaw / 2)
        w, x, y, z = attitudes.T
        return np.column_stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w])


def find_frame(log: FlightLog, scenario: Scenario, *, align: bool = False, start: float | None = None) -> LogFrame:
    """Where a log lies in the race.

    Without `align` its frame is the race's, and it begins when the drone is as far from the start as the reference is then.

    Args:
        log: with positions.
        scenario: with the reference.
        align: find a shift and a turn about z that lay the log over the reference.
        start: [s] of the log's clock at which the race begins.

    Raises:
        InputError: no start is found, or nothing fits.
    """
    if align:
        return _fit(log, scenario, start)
    still = np.zeros(3)
    if start is not None:
        _check_start(log, start)
        return LogFrame(start, 0.0, still, math.nan, "as it was logged; the start as given")
    if log.kind == OWN:
        return LogFrame(0.0, 0.0, still, math.nan, "as it was logged; hotlap's own log begins at the start")
    found = _leave_start(log, log.signals["position"], scenario)
    return LogFrame(found, 0.0, still, math.nan, "as it was logged; the start by when the drone left it")


def _check_start(log: FlightLog, start: float) -> None:
    position = log.signals["position"].times
    if not position[0] <= start < position[-1]:
        raise InputError(
            "", "start", f"must be from {position[0]:.2f} to {position[-1]:.2f} s, where {log.name} has positions, not {start:g}"
        )


def _leave_start(log: FlightLog, position: Signal, scenario: Scenario) -> float:
    """[s] of the log's clock at which the race began: when the drone left the start.

    Raises:
        InputError: it does not come near the start, or does not leave it.
    """
    begin, near = scenario.reference.position[0], _reach(scenario) / 2
    flown = np.linalg.norm(position.values - begin, axis=1)
    if flown.min() > near:
        place = ", ".join(f"{value:.1f}" for value in begin)
        raise InputError(
            log.name,
            "",
            f"comes no nearer than {flown.min():.1f} m to the start of {scenario.race.name} ({place}): "
            "align=... lays it over the reference, start=... says when it began",
        )
    found = _departure(position, begin, float(position.times[int(np.argmax(flown <= near))]), scenario)
    if found is None:
        raise InputError(log.name, "", f"never leaves the start of {scenario.race.name} by more than {2 * near:.1f} m")
    return found


def _reach(scenario: Scenario) -> float:
    """[m] from the start, beyond which a drone has left it."""
    path = scenario.reference.position[: scenario.reference.planned_rows]
    return float(min(REACH, np.linalg.norm(path - path[0], axis=1).max() / 2))


def _departure(position: Signal, place: Floats, earliest: float, scenario: Scenario) -> float | None:
    """[s] of the log's clock at which the race began, from when the drone was as far from a place as the reference from its start.

    Args:
        position: of the log.
        place: shape (3,) [m] where the drone waited.
        earliest: [s] before which nothing counts.
        scenario: with the reference.

    Returns:
        None where it does not leave the place.
    """
    path, far = scenario.reference.position[: scenario.reference.planned_rows], _reach(scenario)
    planned, flown = np.linalg.norm(path - path[0], axis=1), np.linalg.norm(position.values - place, axis=1)
    beyond = np.flatnonzero((flown > far) & (position.times > earliest))
    within = np.flatnonzero((flown <= far / 2) & (position.times >= earliest))
    if not len(beyond) or not (within < beyond[0]).any():
        return None
    before = int(within[within < beyond[0]][-1])
    row = int(np.argmax(planned > far / 2)) - 1
    there = _crossing(position.times[before : before + 2], flown[before : before + 2], far / 2)
    return there - _crossing(scenario.reference.times[row : row + 2], planned[row : row + 2], far / 2)


def _crossing(times: Floats, distances: Floats, distance: float) -> float:
    """[s] at which a distance is reached between two samples."""
    (a, b), (t, u) = distances, times
    return float(t + (u - t) * (distance - a) / (b - a)) if b > a else float(u)


def _fit(log: FlightLog, scenario: Scenario, start: float | None) -> LogFrame:
    """The log laid over the reference: where it has waited on the start, turned so that its path lies nearest to that of the reference.

    Its clock is not fitted, so that who is late stays late. Where it has not waited, shift, turn and start are those that leave the least
    distance from the clocked reference.
    """
    position, length = log.signals["position"], scenario.reference.lap_time
    moments = np.arange(0.0, length, STEP)
    planned = scenario.reference.position_at(moments)
    if start is not None:
        _check_start(log, start)
        best = start
    else:
        last = position.times[-1] - LEAST_SHARE * length
        if last <= position.times[0]:
            raise InputError(log.name, "", f"lasts {position.times[-1] - position.times[0]:.1f} s, too short for a lap of {length:.1f} s")
        best = _best(np.arange(position.times[0], last, COARSE), position, moments, planned)
        near = np.arange(max(best - COARSE, position.times[0]), best + COARSE, FINE)
        best = _best(near, position, moments, planned)
    yaw, shift, residual, share = _lay_over(position.at(best + moments), planned)
    if share > POOR:
        raise InputError(log.name, "", f"no shift and turn lay it over {scenario.race.name}: {residual:.1f} m are left")
    place = _waiting_place(position, best)
    if place is not None:
        began = _departure(position, place, best - WAIT, scenario) if start is None else start
        if began is not None:
            return _anchor(position, place, began, yaw, scenario)
    words = f"{_moved(yaw, shift)} to lie over the clocked reference, which leaves {residual:.2f} m and flatters the errors"
    return LogFrame(best, yaw, shift, residual, words)


def _waiting_place(position: Signal, start: float) -> Floats | None:
    """Where the drone has waited before it flew, shape (3,) [m]; None where it has not."""
    before = position.values[(position.times >= start - WAIT) & (position.times <= start)]
    if len(before) < 2:
        before = position.values[:1] if start - position.times[0] < STEP else before[:0]
    if not len(before):
        return None
    place = np.median(before, axis=0)
    return place if np.linalg.norm(before - place, axis=1).max() < STILL else None


def _anchor(position: Signal, place: Floats, start: float, yaw: float, scenario: Scenario) -> LogFrame:
    """The frame that has the waiting place on the start, and the path nearest to that of the reference."""
    from scipy.spatial import KDTree  # noqa: PLC0415  which takes its time to load

    reference, length = scenario.reference, scenario.reference.lap_time
    path = KDTree(reference.position_at(np.arange(0.0, reference.duration, FINE)))
    flown = position.at(start + np.arange(0.0, length, STEP))
    away = flown[np.isfinite(flown).all(axis=1)] - place
    best, left = yaw, math.inf
    for reach, step in ((TURN, TURN / 40), (TURN / 40, TURN / 1600)):
        for turn in (best + np.arange(-reach, reach + step / 2, step)).tolist():
            frame = LogFrame(start, turn, reference.position[0], math.nan, "")
            distance = float(np.sqrt((path.query(frame.points(away))[0] ** 2).mean()))
            if distance < left:
                yaw, left = turn, distance
        best = yaw
    frame = LogFrame(start, yaw, np.zeros(3), math.nan, "")
    shift = reference.position[0] - frame.points(place[None])[0]
    words = f"{_moved(yaw, shift)}: where it waited is the start, and its path lies {left:.2f} m from that of the reference"
    return LogFrame(start, yaw, shift, left, words)


def _moved(yaw: float, shift: Floats) -> str:
    return f"turned by {math.degrees(yaw):.1f} deg and shifted by ({', '.join(f'{value:.2f}' for value in shift)}) m"


def _best(starts: Floats, position: Signal, moments: Floats, planned: Floats) -> float:
    """The start after which the flight has the form of the reference most of all."""
    left = [_lay_over(position.at(start + moments), planned)[3] for start in starts.tolist()]
    return float(starts[int(np.argmin(left))])


def _lay_over(flown: Floats, planned: Floats) -> tuple[float, Floats, float, float]:
    """Turn about z [rad] and shift that lay points over others, shape (n, 3); what is left [m], and as a share of how far they spread.

    For too few points both are infinite.
    """
    known = np.asarray(np.isfinite(flown).all(axis=1))
    if known.sum() < max(3, LEAST_SHARE * len(flown) - 1):
        return 0.0, np.zeros(3), math.inf, math.inf
    flown, planned = flown[known], planned[known]
    centre, target = flown.mean(axis=0), planned.mean(axis=0)
    here, there = (flown - centre) @ [1, 1j, 0], (planned - target) @ [1, 1j, 0]
    turn = complex(np.vdot(here, there))
    yaw = math.atan2(turn.imag, turn.real)
    frame = LogFrame(0.0, yaw, np.zeros(3), math.nan, "")
    shift = target - frame.points(centre[None])[0]
    left = _spread(frame.points(flown) + shift - planned)
    return yaw, shift, left, left / max(_spread(planned - target), TINY)


def _spread(offsets: Floats) -> float:
    """Root mean square length of some offsets, shape (n, 3)."""
    return float(np.sqrt((offsets**2).sum(axis=1).mean()))
