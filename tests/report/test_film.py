"""A film shows flights as they were, to their end, and is a file that players know."""

from __future__ import annotations

import subprocess
import weakref
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from fake_world import make_scenario
from hall import HALL, make_hall
from hotlap.core.errors import InputError
from hotlap.race.obstacles import Sphere
from hotlap.race.rotors import RotorLayout, rotor_positions, torque_matrix
from hotlap.report.film import recording
from hotlap.report.film.drone import draw_drone, turn
from hotlap.report.film.film import LONGEST, pace_of, write_film
from hotlap.report.film.flight_frames import film_flights
from hotlap.report.film.recording import check_recorder, find_ffmpeg, record
from hotlap.report.page.replay import choose
from hotlap.report.projection import aim, gate_lines, ground_level, rings, standing_lines
from hotlap.report.scene import stage
from plausible_world import OPTIMUM, PlausibleWorld
from studies import begin, carry, configure


@pytest.fixture(scope="module")
def flights():
    """A flight that fails, and a good one."""
    scenario = make_scenario()
    shown = choose(scenario, 40 * np.tile(OPTIMUM, (2, 1)), np.tile(OPTIMUM, (2, 1)))
    return film_flights(scenario, PlausibleWorld(), (shown[1], shown[0]), seed=3, interval=0.1)


def test_a_flight_is_followed_to_its_end_with_a_count_of_its_gates(flights):
    bad, good = flights
    assert (good.failed, good.passed[0], good.passed[-1]) == (False, 0, 5)
    assert good.ending == "all 5 gates, 5.00 s"
    assert bad.failed
    assert bad.ending == f"missed gate {bad.passed[-1] + 1}"
    assert bad.judged < len(bad) - 1  # it is followed on
    for flight in flights:
        assert (np.diff(flight.passed) >= 0).all()
        assert len(flight.position) == len(flight.attitude) == len(flight.speed) == len(flight.passed)
        np.testing.assert_allclose(np.linalg.norm(flight.attitude, axis=1), 1)


class LateWorld(PlausibleWorld):
    """Passes the last gate after the end of the reference, as a rule of approach allows."""

    def fly(self, scenario, parameters, seeds, **options):
        flown, late = super().fly(scenario, parameters, seeds, **options), np.full(len(seeds), scenario.reference.duration + 0.25)
        return replace(flown, end_time=late, lap_time=late)


def test_a_lap_that_ends_after_the_reference_is_seen_to_end():
    scenario = make_scenario()
    (flight,) = film_flights(scenario, LateWorld(), choose(scenario, *2 * [np.tile(OPTIMUM, (2, 1))])[:1], seed=3, interval=0.1)
    assert not flight.failed
    assert flight.judged <= len(flight) - 1


def test_a_camera_keeps_lengths_across_and_up_is_up():
    camera = aim(np.array([[0.0, 0, 0], [10, 0, 0], [5, 2, 1]]))
    assert np.linalg.norm(camera.right) == pytest.approx(1)
    assert np.linalg.norm(camera.up) == pytest.approx(1)
    assert camera.right @ camera.up == pytest.approx(0, abs=1e-12)
    assert camera.up[2] > 0.5
    assert abs(camera.right[0]) > 0.9  # along the track


@pytest.mark.parametrize("normal", [[1.0, 0, 0], [0, 0, 1.0], [0, 0, 0.0], [3.0, -2, 1]])
def test_a_gate_is_a_circle_across_the_flight(normal):
    (ring,) = rings(np.array([[1.0, 2, 3]]), np.array([normal]), 1.3)
    np.testing.assert_allclose(np.linalg.norm(ring - [1, 2, 3], axis=1), 1.3)
    np.testing.assert_allclose((ring - [1, 2, 3]) @ np.array(normal), 0, atol=1e-12)
    np.testing.assert_allclose(ring[0], ring[-1])


def test_a_film_shows_openings_as_they_stand_and_bare_points_as_circles_across_the_plan():
    scene = stage(make_hall())
    lines = gate_lines(scene, 0.01)
    assert len(lines) == len(scene.gates)
    for shape, drawn in zip(scene.structures.gates, lines, strict=True):
        if shape.plane is None:
            (ring,) = drawn
            np.testing.assert_allclose(np.linalg.norm(ring - shape.centre, axis=1), shape.radius)
        else:
            assert len(drawn) == len(shape.rims) + len(shape.walls) + (shape.normal is not None)
            np.testing.assert_array_equal(drawn[0], shape.rims[0])


def test_a_film_shows_obstacles_and_box_but_nothing_far_from_the_track():
    scene = stage(make_hall())
    everything = np.vstack(standing_lines(scene))
    assert {tuple(corner) for corner in everything} >= {HALL.boxes[0].low, HALL.boxes[0].high, HALL.box.low, HALL.box.high}
    far = HALL.model_copy(update={"spheres": (Sphere(position=(9000.0, 0.0, 0.0), radius=1.0),)})
    assert np.vstack(standing_lines(stage(make_hall(far))))[:, 0].max() < 100
    assert standing_lines(stage(make_scenario())) == ()


def test_a_drone_turns_with_its_attitude():
    half = np.sqrt(0.5)
    np.testing.assert_allclose(turn(np.array([half, 0, 0, half]), np.eye(3)), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)
    level = np.vstack(draw_drone(np.zeros(3), np.array([1.0, 0, 0, 0]), 2.0, rotor_positions(RotorLayout.X, 1.0)))
    assert (level[:, 2] == 0).all()


@pytest.mark.parametrize("layout", RotorLayout)
def test_rotors_are_drawn_where_the_plant_has_them(layout):
    """A rotor at (x, y) makes a roll torque of y and a pitch torque of -x for each newton of its thrust."""
    first_arm, second_arm, *rotors = draw_drone(np.zeros(3), np.array([1.0, 0, 0, 0]), 2.0, rotor_positions(layout, 1.0))
    roll, pitch, _ = torque_matrix(layout, 2.0, 0.1)
    hubs = np.stack([-pitch, roll, np.zeros(4)], axis=1)
    np.testing.assert_allclose([rotor[:-1].mean(axis=0) for rotor in rotors], hubs, atol=1e-12)
    np.testing.assert_allclose([first_arm, second_arm], [hubs[[0, 2]], hubs[[1, 3]]], atol=1e-12)


@pytest.mark.parametrize(("duration", "pace"), [(1.0, 1), (13.0, 1), (13.5, 1.25), (26.0, 2), (5000.0, 385)])
def test_a_film_is_never_longer_than_it_may_be(duration, pace):
    assert pace_of(duration) == pace
    assert duration / pace_of(duration) <= LONGEST


@pytest.mark.check
def test_a_gif_has_a_frame_for_each_moment_and_lingers_on_the_last(tmp_path):
    snapshot = carry(tmp_path / "study", replace(configure(), first_guess=np.tile([10.0, 1200.0, 5.0, 200.0, 2.0], (2, 1))))
    path = write_film(tmp_path / "lap.gif", snapshot, PlausibleWorld())
    with Image.open(path) as picture:
        assert picture.format == "GIF"
        assert picture.n_frames > 50
        picture.seek(picture.n_frames - 1)
        assert picture.info["duration"] > 1000
        last = np.asarray(picture.convert("RGB"))
        picture.seek(0)
        assert (np.asarray(picture.convert("RGB")) != last).any()
    assert path.stat().st_size < 3e6
    assert [entry.name for entry in tmp_path.iterdir() if entry.is_file()] == ["lap.gif"]


@pytest.mark.check
def test_a_study_without_flights_has_a_film(tmp_path):
    snapshot = begin(tmp_path / "study", configure())
    with Image.open(write_film(tmp_path / "lap.gif", snapshot, PlausibleWorld(crash=True))) as picture:
        assert picture.n_frames > 10


def frames(count=12, width=64, height=32):
    for k in range(count):
        frame = np.zeros((height, width, 3), dtype=np.uint8)
        frame[:, : 4 * k] = 255
        yield frame


@pytest.mark.check
def test_an_mp4_is_played_by_ffmpeg(tmp_path):
    path = record(tmp_path / "lap.mp4", frames())
    played = subprocess.run([find_ffmpeg(), "-i", path, "-f", "null", "-"], capture_output=True, text=True, check=True)
    assert "h264" in played.stderr
    assert "64x32" in played.stderr


@pytest.mark.check
def test_an_mp4_is_written_frame_by_frame(tmp_path):
    """Hundreds of frames in memory at once would be half a gigabyte."""
    alive, most = [], 0

    def watched():
        nonlocal most
        for frame in frames(count=60):
            alive.append(weakref.ref(frame))
            most = max(most, sum(known() is not None for known in alive))
            yield frame
            del frame

    record(tmp_path / "lap.mp4", watched())
    assert len(alive) == 60
    assert most < 10


def test_without_ffmpeg_an_mp4_is_refused_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "find_ffmpeg", lambda: "")
    with pytest.raises(InputError, match=r"lap\.mp4: needs ffmpeg, which is not on the PATH"):
        check_recorder(tmp_path / "lap.mp4")
    check_recorder(tmp_path / "lap.gif")


@pytest.mark.parametrize("name", ["lap.gif", "lap.mp4"])
def test_a_film_that_cannot_be_written_is_an_input_error(tmp_path, name):
    with pytest.raises(InputError, match="cannot be written"):
        record(tmp_path / "nowhere" / name, frames())


def test_the_ground_of_a_film_is_the_floor_on_which_something_stands():
    assert ground_level(stage(make_hall())) == HALL.floor
    bare = make_scenario()
    assert ground_level(stage(bare)) < bare.reference.position[:, 2].min()
