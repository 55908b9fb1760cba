"""`hotlap identify`."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.files.descriptions import load_quadrotor
from hotlap.identification.identify import identify
from hotlap.identification.replay import replay
from hotlap.logs.hotlap_csv import write_hotlap_csv
from hotlap.race.hold import parse_hold
from identification.flights import BASE, drawn


@pytest.fixture(scope="module")
def flown():
    """The first eight seconds, with roll doublets and without turns of yaw; compiles all before there is an empty cache."""
    replay(BASE, np.zeros((1, 4)))
    return drawn(3).fly(3, seconds=8.0)


@pytest.fixture(scope="module")
def found(flown):
    return identify([flown], BASE)


@pytest.fixture
def flight(flown, here):
    path = here / "flight.csv"
    write_hotlap_csv(path, flown)
    return path.name


@pytest.mark.check
def test_numbers_predictions_and_what_is_missing_are_said_and_written(hotlap, here, flight):
    ran = hotlap("identify", flight, "--quadrotor", "five-inch", "--known", "thrust", "--out", "mine.toml", "--picture", "seen.png")
    assert ran.code == 0
    first, *others = ran.out.splitlines()
    assert first == "five-inch, from 1 log of 8 s; taken to be right: its thrust"
    assert any(line.startswith("  mass") for line in others)
    assert any(line.startswith("  rate gain yaw: yaw was hardly asked to turn") for line in others)
    assert others[-2:] == ["picture written to seen.png", "wrote mine.toml; next: hotlap check mine.toml"]
    assert (here / "seen.png").stat().st_size > 10_000
    mine, base = load_quadrotor(here / "mine.toml"), load_quadrotor("five-inch")
    assert mine.rotor_thrust == base.rotor_thrust
    assert mine.mass == pytest.approx(drawn(3).vehicle.mass, rel=0.02)
    assert mine.rate_gain[2] == base.rate_gain[2]
    assert "stages" in ran.err


def test_a_base_beside_the_file_is_found_from_it(found, hotlap, here, flight, monkeypatch):
    monkeypatch.setattr("hotlap.api.identified.identify", lambda *_, **__: found)
    (here / "base.toml").write_text('base = "five-inch"\nmass = 0.7\n')
    (here / "found").mkdir()
    ran = hotlap("identify", flight, "--quadrotor", "base.toml", "--out", "found/mine.toml", "--json")
    assert ran.document["file"] == "found/mine.toml"
    assert 'base = "../base.toml"' in (here / "found" / "mine.toml").read_text()
    assert load_quadrotor(here / "found" / "mine.toml").mass == 0.7


def test_what_is_outside_of_a_window_is_not_fitted(found, hotlap, flight, monkeypatch):
    seen = []
    monkeypatch.setattr("hotlap.api.identified.identify", lambda logs, *_, **__: seen.extend(logs) or found)
    assert hotlap("identify", flight, "--quadrotor", "five-inch", "--from", "1", "--to", "7.5").code == 0
    assert (seen[0].start, seen[0].duration) == pytest.approx((1.0, 6.5), abs=0.011)
    assert any(note.startswith("from 1.00 to 7.50 s of a log from 0.00 to") for note in seen[0].notes)
    assert hotlap("identify", flight, "--quadrotor", "five-inch", "--from", "99").err.startswith(
        "hotlap: --from: leaves nothing of flight.csv"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--quadrotor", "five-inch"), "LOG: is missing; see hotlap identify --help"),
        (("nowhere.csv",), "--quadrotor: is missing; see hotlap identify --help"),
        (("nowhere.csv", "--quadrotor", "five-inch"), "nowhere.csv: there is no such file"),
        (("nowhere.csv", "--quadrotor", "five-inch", "--out", "mine.yaml"), "mine.yaml: must end with .toml"),
        (("a.csv", "--quadrotor", "five-inch", "--picture", "seen.gif"), "seen.gif: must end with .png, .svg, .pdf"),
        (("a.csv", "--quadrotor", "five-inch", "--from", "soon"), "--from: must be a number, not 'soon'"),
        (("a.csv", "--quadrotor", "five-inch", "--from", "9", "--to", "3"), "--to: is 3 s, which is not after 9 s"),
        (("straight.toml", "--quadrotor", "five-inch"), "straight.toml: is no log that hotlap knows: PX4 ULog"),
    ],
)
def test_bad_input_is_one_line(hotlap, arguments, message):
    ran = hotlap("identify", *arguments)
    assert ran.code == 2
    assert ran.err.startswith(f"hotlap: {message}")
    assert ran.err.count("\n") == 1


@pytest.mark.parametrize(
    ("known", "reason"),
    [
        ("mas", "there is no quantity named 'mas' (did you mean mass?); available: mass, rate_loop, thrust"),
        ("mass,thrust", "a log cannot tell mass from thrust: one of the two, not both, has to be known"),
        ("rate_loop", "a log cannot tell mass from thrust: one of the two, not both, has to be known"),
    ],
)
def test_what_is_known_is_mass_or_thrust_and_perhaps_the_rate_loop(hotlap, flight, known, reason):
    ran = hotlap("identify", flight, "--quadrotor", "five-inch", "--known", known)
    assert (ran.code, ran.err) == (2, f"hotlap: --known: {reason}\n")


def test_the_uncertainty_is_told_in_the_words_of_hold(hotlap, found, flight, monkeypatch):
    monkeypatch.setattr("hotlap.api.identified.identify", lambda *_, **__: found)
    ran = hotlap("identify", flight, "--quadrotor", "five-inch", "--json")
    assert parse_hold(ran.document["hold"])
    said = hotlap("identify", flight, "--quadrotor", "five-inch").out
    assert f'--hold "{ran.document["hold"]}"' in said
