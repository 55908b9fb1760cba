"""What a page reads is what a study holds, as plain JSON; whatever the study has come to."""

from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np
import pytest

from fake_world import make_scenario
from hall import GATES, HALL, POINT, UNCOUNTED, make_hall
from hotlap.core.ledger import Ledger
from hotlap.core.seeds import Stream
from hotlap.files import toml_writer
from hotlap.files.descriptions import load_parameters, load_race
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.race.rotors import RotorLayout
from hotlap.report.effort import Effort
from hotlap.report.page.document import MOST_SAMPLES, dump_scenario, dump_study, dump_trace, write_json
from hotlap.report.page.packing import MOST_ROWS, number, pack, thin
from hotlap.report.page.replay import replay_finished, replay_running, typical
from hotlap.report.scene import trace
from plausible_world import PlausibleWorld
from studies import AnyVehicle, begin, carry, configure

KEYS = {
    *("format", "kind", "live", "headline", "scenario", "traces", "repeats", "flights", "parameters", "samples", "sensitivity"),
    *("robustness", "advice", "configuration"),
}


def unpack(packed):
    return np.frombuffer(base64.b64decode(packed["f32"]), dtype="<f4").reshape(packed["shape"])


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    guess = np.tile([10.0, 1200.0, 5.0, 200.0, 2.0], (2, 1))
    asked = replace(configure(goal="mean_error<0.01", budget=60), first_guess=guess, first_guess_name="my guesses/mine.toml")
    world = PlausibleWorld(noise=0.02)
    return carry(tmp_path_factory.mktemp("study"), asked, world, "hotlap tune straight.toml --first-guess 'my guesses/mine.toml'")


@pytest.fixture(scope="module")
def whole(study):
    """The document of a finished study, gone through JSON."""
    replay = replay_finished(study.configuration, AnyVehicle(), study.best)
    return json.loads(write_json(dump_study(study, replay)))


def test_an_array_comes_back_as_it_was_to_single_precision():
    values = np.array([[1.5, np.nan, -2.25], [0.1, np.inf, 1e-30]])
    np.testing.assert_array_equal(unpack(pack(values)), values.astype("<f4"))
    assert unpack(pack(np.zeros((0, 3)))).shape == (0, 3)


@pytest.mark.parametrize(("rows", "kept"), [(0, 0), (1, 1), (MOST_ROWS, MOST_ROWS), (MOST_ROWS + 1, MOST_ROWS // 2 + 1)])
def test_long_series_are_thinned_evenly(rows, kept):
    assert len(np.arange(rows)[thin(rows)]) == kept


def test_json_ends_no_element_and_holds_no_number_that_json_has_not():
    assert "</script" not in write_json({"name": "</script><script>"})
    assert json.loads(write_json({"name": "</script>ü"})) == {"name": "</script>ü"}
    assert number(float("nan")) is number(float("inf")) is None
    with pytest.raises(ValueError, match="JSON"):
        write_json({"value": float("nan")})


def test_the_whole_has_every_key(whole):
    assert set(whole) == KEYS
    assert (whole["format"], whole["kind"], whole["live"]) == (1, "study", False)


def test_the_headline_says_what_the_study_says(study, whole):
    head, result = whole["headline"], study.result
    said = head["race"], head["tuner"], head["goal"], head["state"]
    assert said == ("straight", "metropolis_hastings:tied", "mean_error<0.01", "finished")
    assert (head["flights"], head["search_flights"], head["confirmed"]) == (result.flights, result.search_flights, result.best.confirmed)
    assert head["planned_lap_time"] == study.configuration.scenario.reference.lap_time


def test_latency_that_the_controller_does_not_know_is_the_difference(tmp_path):
    scenario = make_scenario()
    late = scenario.race.vehicle.model_copy(update={"delay": 0.045})
    for model, unknown in ((scenario.race.vehicle, 0.045), (late, 0.0)):
        race = scenario.race.model_copy(update={"vehicle": late, "model": model})
        snapshot = begin(tmp_path / str(unknown), configure(replace(scenario, race=race)))
        assert dump_study(snapshot, None)["headline"]["latency_unknown"] == unknown


def test_every_flight_is_there_in_the_order_of_the_ledger(study, whole):
    flights, ledger = whole["flights"], study.ledger
    np.testing.assert_allclose(unpack(flights["cost"]), ledger.cost, rtol=1e-6)
    np.testing.assert_allclose(unpack(flights["number"]), ledger.numbers + 1)
    assert [Stream(stream) for stream in flights["stream"]] == ledger.streams.tolist()
    assert flights["accepted"] == ledger.accepted.tolist()
    assert flights["tuned"] == [bool((one == study.best).all()) for one in ledger.parameters]
    assert sum(flights["tuned"]) >= 1, "the parameters that are kept were flown"
    assert flights["succeeded"] == ((ledger.completion >= 1) & (ledger.mean_error < 0.01)).tolist()


def test_traces_are_flights_of_their_own_noise(study, whole):
    assert [trace["id"] for trace in whole["traces"]] == ["best", "first", "default"]
    assert not {trace["seed"] for trace in whole["traces"]} & set(study.ledger.seeds.tolist())
    for flown in whole["traces"]:
        rows = flown["time"]["shape"][0]
        for name, width in {"position": 3, "attitude": 4, "rates": 3, "rotor_thrusts": 4, "command_rates": 3}.items():
            assert flown[name]["shape"] == [rows, width]
        assert flown["speed"]["shape"] == flown["error"]["shape"] == flown["command_thrust"]["shape"] == [rows]
        assert set(flown["effort"]) - {"reference"} == set(flown["effort"]["reference"])


def test_the_means_say_over_how_many_flights_they_are(study, whole):
    kept, best = whole["headline"]["kept"], study.result.best
    assert (kept["flights"], kept["cost"], kept["selection_flights"]) == (best.flights, best.cost, study.result.selection_flights)


@pytest.mark.parametrize("recorded", [[0, 1, 2, 3, 4], [0, 2], [3]])
def test_the_flight_that_is_shown_is_the_recorded_one_nearest_the_middle(recorded):
    scenario = make_scenario()
    parameters = np.tile(scenario.space.first_guess(len(scenario.segments)), (5, 1, 1))
    flown = PlausibleWorld().fly(scenario, parameters, np.arange(5), log=recorded)
    flown = replace(flown, gates_passed=np.array([1, 4, 4, 4, 0]), mean_error=np.array([0.1, 0.3, 0.2, 0.1, np.nan]))
    order = [4, 0, 1, 2, 3]  # by gates passed, then by error, the worst first
    ranks = {index: abs(order.index(index) - 2) for index in recorded}
    assert ranks[typical(flown, slice(0, 5))] == min(ranks.values())


def test_repeats_add_up(whole):
    for repeats in whole["repeats"]:
        assert repeats["complete"] + len(repeats["ends"]) == repeats["flights"]
        assert repeats["failures"]["shape"] == [len(repeats["ends"]), 3]
        assert len(repeats["failed_gates"]) == len(repeats["ends"])
        assert 0 <= repeats["low"] <= repeats["complete"] / repeats["flights"] <= repeats["high"] <= 1


def test_parameters_lie_within_their_bounds(whole):
    parameters = whole["parameters"]
    low, high = (unpack(parameters[name]) for name in ("low", "high"))
    for name in ("default", "first", "best"):
        values = unpack(parameters[name])
        assert values.shape == (2, len(parameters["names"]))
        assert ((values >= low) & (values <= high)).all()
    assert len(parameters["symbols"]) == len(parameters["units"]) == len(parameters["names"])


def test_the_race_can_be_read_again(whole, study, tmp_path):
    (tmp_path / "race.toml").write_text(whole["configuration"]["race_toml"], encoding="utf-8")
    assert load_race(tmp_path / "race.toml") == study.configuration.scenario.race
    assert toml_writer.write(study.configuration.scenario.race.model_dump(mode="json", exclude_none=True))


def test_the_parameters_can_be_read_again(whole, study, tmp_path):
    (tmp_path / "parameters.toml").write_text(whole["configuration"]["parameters_toml"], encoding="utf-8")
    np.testing.assert_array_equal(load_parameters(tmp_path / "parameters.toml").values, study.best)


def test_the_command_is_the_one_that_was_given_and_names_the_first_guess(tmp_path, whole):
    assert whole["configuration"]["command"] == "hotlap tune straight.toml --first-guess 'my guesses/mine.toml'"
    assert whole["headline"]["first_guess"] == "my guesses/mine.toml"
    document = dump_study(begin(tmp_path, configure()), None)
    assert document["configuration"]["command"].endswith("--first-guess default")
    assert document["headline"]["first_guess"] == "given", "a program gave numbers"


def test_a_study_without_its_command_gets_one_that_names_the_first_guess(tmp_path):
    asked = replace(configure(), first_guess=np.tile([10.0, 1200.0, 5.0, 200.0, 2.0], (2, 1)), first_guess_name="my guesses/mine.toml")
    assert dump_study(begin(tmp_path, asked), None)["configuration"]["command"].endswith("--first-guess 'my guesses/mine.toml'")


def test_many_samples_are_thinned_and_the_page_is_told_of_how_many(study):
    search = study.ledger.of(Stream.SEARCH)
    times = 2 * MOST_SAMPLES // len(search) + 1
    samples = dump_study(replace(study, ledger=Ledger.join([study.ledger] * times)), None)["samples"]
    assert samples["parameters"]["shape"] == [MOST_SAMPLES, 2, 5]
    assert len(samples["accepted"]) == len(samples["succeeded"]) == MOST_SAMPLES
    assert samples["of"] == times * len(search) > MOST_SAMPLES


def test_a_study_without_flights_has_a_document(tmp_path):
    snapshot = begin(tmp_path, configure())
    for replay in (None, replay_running(snapshot.configuration, PlausibleWorld(), snapshot.best)):
        document = json.loads(write_json(dump_study(snapshot, replay, live=True)))
        assert set(document) == KEYS
        assert (document["headline"]["state"], document["headline"]["completion"], document["live"]) == ("running", None, True)
        assert (document["sensitivity"], document["robustness"], document["samples"]["of"]) == (None, [], 0)


@pytest.mark.parametrize(
    ("world", "goal"),
    [(PlausibleWorld(reach=40.0, crash=True), "none"), (PlausibleWorld(reach=20.0), "completion=1"), (PlausibleWorld(), "mean_error<0.01")],
)
def test_a_study_of_failures_has_a_document(tmp_path, world, goal):
    snapshot = carry(tmp_path, configure(goal=goal), world)
    document = json.loads(write_json(dump_study(snapshot, replay_finished(snapshot.configuration, world, snapshot.best))))
    assert document["robustness"] == []  # this world flies what it has
    assert document["sensitivity"]["by_segment"]["shape"] == [2, 5]


NAMES = {GateRule.CLOCK: "clock", GateRule.CLOSEST: "approach", GateRule.RELEASED: "approach", GateRule.OPENING: "opening"}


@pytest.mark.parametrize(("rule", "name"), NAMES.items())
def test_the_rule_is_one_of_three(tmp_path, rule, name):
    snapshot = begin(tmp_path, configure(make_scenario(JudgeSettings(rule=rule, fly_on=True))))
    assert dump_study(snapshot, None)["scenario"]["rule"] == name


def test_a_flight_that_never_turns_has_no_frequency(study):
    replay = replay_running(study.configuration, PlausibleWorld(), study.best)
    still, shaking = Effort(0.0, 0.0, 0.0, 0.0, 0.0), Effort(1.0, 2.0, 0.0, 8.0, 0.5)
    effort = dump_trace(replay.scene.traces[0], (still, shaking))["effort"]
    assert effort["oscillation"] == {"frequency": None, "share": 0.0}
    assert effort["reference"]["oscillation"] == {"frequency": 8.0, "share": 0.5}


@pytest.mark.parametrize("layout", list(RotorLayout))
def test_the_rotors_are_where_the_plant_has_them(layout):
    """A rotor at (x, y) makes a roll torque of y and a pitch torque of -x for each newton of its thrust."""
    scenario = make_scenario()
    vehicle = scenario.race.vehicle.model_copy(update={"layout": layout})
    document = dump_scenario(replace(scenario, race=scenario.race.model_copy(update={"vehicle": vehicle})))
    x, y = np.array(json.loads(write_json(document))["rotors"]).T
    np.testing.assert_allclose([y, -x], vehicle.torque_matrix[:2], atol=1e-15)
    np.testing.assert_allclose(np.hypot(x, y), vehicle.arm)
    assert (x[0], y[0]) == pytest.approx((vehicle.arm, 0) if layout is RotorLayout.PLUS else (vehicle.arm * 0.5**0.5,) * 2)  # in front


def test_gates_that_are_more_than_points_are_sent_once_with_their_lines_about_their_centres():
    scenario = make_hall()
    document = json.loads(write_json(dump_scenario(scenario)))
    shapes = document["gate_shapes"]
    assert len(shapes) == len(GATES) - 2  # two bare points
    counted = sorted(gate for shape in shapes for gate in shape["gates"])
    assert counted == [gate for gate in range(18) if scenario.race.track.counted[gate] != POINT]
    for shape in shapes:
        for gate in shape["gates"]:
            np.testing.assert_array_equal(shape["centre"], scenario.race.track.counted[gate].position)
        for line in map(unpack, shape["rims"]):
            if shape["normal"]:
                np.testing.assert_allclose(np.abs(line @ np.array(shape["normal"])), shape["depth"] / 2, atol=1e-6)
            assert np.linalg.norm(line, axis=1).max() >= shape["reach"] - 1e-6
    (point,) = unpack(document["points"])
    np.testing.assert_array_equal(point, UNCOUNTED.position)


def test_obstacles_box_and_ceiling_are_sent_as_they_are_written():
    document = json.loads(write_json(dump_scenario(make_hall())))
    for kind in ("poles", "spheres", "boxes"):
        assert document[kind] == json.loads(json.dumps([one.model_dump() for one in getattr(HALL, kind)]))
    assert document["box"] == {"low": list(HALL.box.low), "high": list(HALL.box.high)}
    assert document["ceiling"] == HALL.ceiling
    np.testing.assert_allclose(document["bounds"], [HALL.box.low, HALL.box.high])


def test_a_track_of_bare_points_sends_points_alone():
    document = dump_scenario(make_scenario())
    assert document["gate_shapes"] == document["poles"] == document["spheres"] == document["boxes"] == []
    assert document["box"] is document["ceiling"] is document["bounds"] is None


def test_estimates_are_drawn_where_the_controller_makes_some(whole):
    assert all(trace["thrust_effectiveness"] is trace["disturbance"] is None for trace in whole["traces"])
    scenario, effort = make_scenario(), Effort(0.0, 0.0, 0.0, None, None)
    for on in (True, False):
        race = scenario.race.model_copy(update={"controller": scenario.race.controller.model_copy(update={"offset_free": on})})
        asked = replace(scenario, race=race)
        parameters = asked.space.first_guess(len(asked.segments))[None]
        flights = PlausibleWorld().fly(asked, parameters, np.zeros(1, dtype=np.int64), log=[0])
        log = flights.logs[0]
        estimates = np.tile([0.9, 3.0, 0.0, 4.0], (len(log.times), 1))
        plain = dump_trace(trace(asked, replace(flights, logs={0: replace(log, estimates=estimates)}), 0, "best"), (effort, effort))
        assert (plain["thrust_effectiveness"] is None) == (not on)
        if on:
            np.testing.assert_allclose(unpack(plain["thrust_effectiveness"]), 0.9, rtol=1e-6)
            np.testing.assert_allclose(unpack(plain["disturbance"]), 5.0)


@pytest.mark.parametrize(("tuner", "chain"), [("metropolis_hastings:tied", True), ("simulated_annealing", True), ("gate_gp", False)])
@pytest.mark.parametrize(
    ("goal", "words"), [("completion=1", ["passed the goal", "failed the goal"]), ("none", ["passed every gate", "missed a gate"])]
)
def test_flights_are_told_by_the_goal_and_only_chains_accept(tmp_path, tuner, chain, goal, words):
    document = dump_study(begin(tmp_path, replace(configure(goal=goal), tuner=tuner)), None)
    for part in ("flights", "samples"):
        assert document[part]["chain"] is chain
        assert document[part]["verdicts"] == words
