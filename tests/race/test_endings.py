"""How flights ended, in words."""

from __future__ import annotations

import pytest

from fake_world import make_scenario
from hotlap.core.records import Cause, End
from hotlap.race.endings import in_words

RACE = make_scenario().race


@pytest.mark.parametrize(
    ("end", "passed", "cause", "index", "words"),
    [
        (End.FINISHED, 5, Cause.NONE, -1, "all 5 gates"),
        (End.MISSED, 2, Cause.NONE, -1, "missed gate 3"),
        (End.CRASHED, 0, Cause.FLOOR, -1, "hit the floor before gate 1"),
        (End.CRASHED, 1, Cause.DISTANCE, -1, "crashed before gate 2: 10 m from the reference"),
        (End.CRASHED, 2, Cause.POLE, 1, "crashed into pole 2 before gate 3"),
        (End.CRASHED, 2, Cause.FRAME, 2, "touched the frame of gate 3"),
        (End.CRASHED, 3, Cause.FRAME, 2, "touched the frame of gate 3 before gate 4"),
        (End.CRASHED, 3, Cause.OUTSIDE, -1, "left the box before gate 4"),
        (End.CRASHED, 3, Cause.NONE, -1, "crashed before gate 4"),
    ],
)
def test_an_ending_says_what_happened_and_where(end, passed, cause, index, words):
    assert in_words(RACE, end, passed, cause, index) == words


@pytest.mark.parametrize("cause", list(Cause))
def test_every_cause_has_words_of_its_own(cause):
    others = {in_words(RACE, End.CRASHED, 1, other, 1) for other in Cause if other is not cause}
    assert in_words(RACE, End.CRASHED, 1, cause, 1) not in others


def test_gates_of_laps_are_named_with_their_lap():
    track = RACE.track.model_copy(update={"laps": 2})
    race = RACE.model_copy(update={"track": track})
    assert in_words(race, End.MISSED, 6) == "missed gate 2 of lap 2"
    assert in_words(race, End.CRASHED, 6, Cause.FRAME, 1) == "touched the frame of gate 2 of lap 2"
    assert in_words(race, End.CRASHED, 6, Cause.FRAME, 2) == "touched the frame of gate 3 before gate 2 of lap 2"


def test_a_track_of_one_gate_has_no_gates():
    race = RACE.model_copy(update={"track": RACE.track.model_copy(update={"gates": RACE.track.gates[:1]})})
    assert in_words(race, End.FINISHED, 1) == "the only gate"
