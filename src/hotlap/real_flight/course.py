"""Course: all that a real flight flies, made ready before the vehicle moves, so that nothing is planned or compiled in the air."""

from __future__ import annotations

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Floats
from hotlap.real_flight.geofence import Geofence, geofence_of
from hotlap.real_flight.legs import Along, Guided
from hotlap.real_flight.paths import offset_free, path_from_rest, scenario_of, with_braking, yaw_of
from hotlap.real_flight.place import Place, place_here
from hotlap.real_flight.settings import FlightSettings
from hotlap.reference.scenario import Scenario

LIFTED = 0.1  # m above the ground, where it is known to have taken off
CLIMBS = 0.3  # m below the start, from which it climbs first
FAR = 30.0  # m to the start at most, where no geofence is given: that around the path would go wherever a wrong origin leads
ABOVE_GROUND = 1.5  # m of a start whose track has no floor, where the race is placed above the vehicle


class Course:
    """The legs of a flight.

    Args:
        scenario: what is flown.
        parameters: shape (S, K).
        settings: of the flight.
        steers: whether hotlap's controllers fly; False: the vehicle's own does, and is told the reference.

    Attributes:
        scenario: the race, which ends with braking.
        race: the tuned controller on it, or the vehicle's own.
        braking: a controller that learns, on the same; or the vehicle's own.
        stand: hovering where braking ends.

    Raises:
        InputError: the race has a flying start, or does not fit into the geofence.
    """

    def __init__(self, scenario: Scenario, parameters: Parameters, settings: FlightSettings, *, steers: bool = True) -> None:
        if any(scenario.race.track.start_velocity):
            raise InputError("", "race", f"{scenario.race.name} has a flying start, and a real flight begins from hovering")
        self._settings, self._steers, self.scenario = settings, steers, with_braking(scenario)
        self._default = scenario.space.first_guess(1)
        reference = self.scenario.reference
        self._fence(reference.position)
        self.race = Guided(self.scenario, parameters, races=True) if steers else Along(self.scenario, races=True)
        self.braking = Guided(offset_free(self.scenario), parameters) if steers else self.race
        heading = yaw_of(reference.attitude[-1])
        self.stand = self.hover(reference.position[-1:], (heading, heading))

    @property
    def start(self) -> Floats:
        """Shape (3,) [m] (race)."""
        return self.scenario.reference.position[0]

    def above(self, state: Floats) -> Place:
        """The place at which the race starts above a vehicle, whose state in its own world is given, shape (13,)."""
        reference, floor = self.scenario.reference, self.scenario.race.track.floor
        ground = floor if floor is not None else float(self.start[2]) - ABOVE_GROUND
        return place_here(state, self.start, reference.attitude[0], ground)

    def approach(self, state: Floats, *, stands: bool) -> tuple[Along, Geofence]:
        """The way to the start: up first, where that is higher; and the geofence of the whole flight.

        Args:
            state: shape (13,) where the vehicle is (race).
            stands: whether it is on the ground.

        Raises:
            InputError: the flight leaves the geofence, or the start is far away.
        """
        away = float(np.linalg.norm(state[:3] - self.start))
        if away > FAR and not self._settings.geofence:
            told = f"the start of the race is {away:.0f} m from the vehicle: does the race lie there? A geofence that is given allows it"
            raise InputError("", "origin", told)
        here = state[:3].copy()
        if stands:
            here[2] += LIFTED
        points = [here, self.start]
        above = np.array([here[0], here[1], self.start[2]])
        if self.start[2] > here[2] + CLIMBS and np.linalg.norm(self.start - above) > LIFTED:
            points.insert(1, above)
        path = np.array(points)
        try:
            fence = self._fence(np.vstack([state[:3], path, self.scenario.reference.position]))
        except InputError as error:
            place = ", ".join(f"{value:.1f}" for value in state[:3])
            raise InputError(error.source, error.key, f"{error.reason}; the vehicle is at ({place}) m") from None
        return self.hover(path, (yaw_of(state[3:7]), yaw_of(self.scenario.reference.attitude[0]))), fence

    def hover(self, points: Floats, yaws: tuple[float, float], *, learns: bool = True) -> Along:
        """Straight lines between points, and hovering at the last.

        Args:
            points: shape (n, 3) [m] (race).
            yaws: [rad] at the first and at the last.
            learns: whether the controller learns what thrust is worth; not where its commands are not flown.
        """
        gravity = self.scenario.race.control_model.gravity
        path = path_from_rest(points, yaws, self._settings.speed, self._settings.acceleration, gravity)
        scenario = offset_free(scenario_of(self.scenario.race, path), on=learns)
        return Guided(scenario, self._default) if self._steers else Along(scenario)

    def _fence(self, path: Floats) -> Geofence:
        return geofence_of(path, self.scenario.race.track, self._settings.geofence, self._settings.margin)
