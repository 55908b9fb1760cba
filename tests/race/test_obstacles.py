import pytest
from pydantic import ValidationError

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_track
from hotlap.race.obstacles import Box, Pole, Sphere


def test_a_pole_may_be_endless():
    assert (Pole(position=(0.0, 0.0), radius=0.1).top, Pole(position=(0.0, 0.0), radius=0.1).bottom) == (None, None)


@pytest.mark.parametrize(
    ("obstacle", "keys", "message"),
    [
        (Pole, {"position": (0.0, 0.0), "radius": 0.1, "top": 1.0, "bottom": 1.0}, "top: does not lie above bottom"),
        (Pole, {"position": (0.0, 0.0), "radius": 0.0}, "greater than 0"),
        (Pole, {"position": (0.0, 0.0, 0.0), "radius": 0.1}, "at most 2 items"),
        (Sphere, {"position": (0.0, 0.0, 0.0), "radius": -1.0}, "greater than 0"),
        (Box, {"low": (0.0, 0.0, 0.0), "high": (1.0, 0.0, 1.0)}, "low: its y of 0 is not below that of high, 0"),
        (Box, {"low": (0.0, 0.0, 2.0), "high": (1.0, 1.0, 1.0)}, "low: its z of 2 is not below that of high, 1"),
    ],
)
def test_an_impossible_obstacle_is_refused_with_its_key(obstacle, keys, message):
    with pytest.raises(ValidationError, match=message):
        obstacle(**keys)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("poles = [{ position = [0, 0], radius = 0.1, top = 0, bottom = 1 }]", "poles[0].top"),
        ("poles = [{ position = [0, 0] }]", "poles[0].radius"),
        ("poles = [{ position = [0, 0, 1], radius = 0.1 }]", "poles[0].position"),
        ("spheres = [{ position = [0, 0, 1], radius = 0.1 }, { position = [0, 0, 1], radius = 0 }]", "spheres[1].radius"),
        ("boxes = [{ low = [0, 0, 1], high = [1, 1, 0] }]", "boxes[0].low"),
        ("box = { low = [0, 0, 0], high = [1, 1, 1], name = 1 }", "box.name"),
        ("poles = [{ position = [0, 0], radius = 0.1, top = 1e300 }]", "poles[0].top"),
        ("poles = [{ position = [0, 1e9], radius = 0.1 }]", "poles[0].position[1]"),
        ("boxes = [{ low = [0, 0, -1e308], high = [1, 1, 1e308] }]", "boxes[0].low[2]"),
    ],
)
def test_a_fault_in_a_file_names_obstacle_and_key(text, key, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f"start = [0, 0, 0]\ngates = [[1, 0, 0]]\n{text}\n")
    with pytest.raises(InputError) as caught:
        load_track(path)
    assert caught.value.key == key
