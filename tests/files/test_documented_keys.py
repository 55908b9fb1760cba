import pytest

from hotlap.files.documented_keys import documented_keys, table_of
from hotlap.race import gate, obstacles, race, track
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.schema import Described

DESCRIPTIONS = [
    track.Track,
    gate.Gate,
    gate.Opening,
    obstacles.Pole,
    obstacles.Sphere,
    obstacles.Box,
    Quadrotor,
    race.Race,
    race.PlanningSettings,
    race.Ramp,
    race.ControllerSettings,
    race.NoiseSettings,
    race.JudgeSettings,
]


@pytest.mark.parametrize("description", DESCRIPTIONS)
def test_every_key_has_a_meaning(description):
    for key in documented_keys(description):
        assert key.meaning, key.name


@pytest.mark.parametrize("description", DESCRIPTIONS)
def test_every_number_with_a_dimension_has_its_unit(description):
    counts = {"nodes", "sweeps", "input_weights", "low", "high", "default"}
    for key in documented_keys(description):
        if isinstance(key.default, float) and key.name not in counts:
            assert key.unit, key.name


def test_units_stand_apart_from_meanings():
    mass = next(key for key in documented_keys(Quadrotor) if key.name == "mass")
    assert (mass.unit, mass.required, mass.default) == ("kg", True, None)
    assert not mass.meaning.startswith("[")


def test_a_table_is_known_through_options_and_lists():
    assert table_of(race.PlanningSettings, "ramp") is race.Ramp
    assert table_of(track.Track, "gates") is track.Gate
    assert table_of(Quadrotor, "mass") is None
    assert table_of(Quadrotor, "nothing") is None


def test_choices_are_listed():
    rule = next(key for key in documented_keys(race.JudgeSettings) if key.name == "rule")
    assert rule.meaning.endswith("clock, closest, opening, released")


class Rod(Described):
    """A thing with one key."""

    length: float = 1.0
    """[m] from one end
    to the other. None: unknown."""


def test_the_docstring_below_a_key_is_its_documentation():
    (key,) = documented_keys(Rod)
    assert (key.name, key.unit, key.default, key.required) == ("length", "m", 1.0, False)
    assert key.meaning == "from one end to the other. Without it: unknown"
