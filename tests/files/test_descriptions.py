import tomllib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.renamed import RenamedWarning
from hotlap.files import descriptions, toml_writer
from hotlap.files.descriptions import Kind, load, load_quadrotor, load_race, load_track, names, save
from hotlap.files.documented_keys import documented_keys
from hotlap.files.recognition import TYPES
from hotlap.race.race import GateRule
from hotlap.system.text_files import create

QUADROTOR = "mass = 0.85\ninertia = [1e-3, 1e-3, 1.7e-3]\narm = 0.15\nrotor_thrust = [0.0, 6.9]\ntorque_ratio = 0.05\n"
TRACK = "start = [0, 0, 0]\ngates = [[1, 2, 3], [4, 5, 6]]\n"
RACE = 'track = "circle"\nvehicle = "hummingbird"\n'


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Write a file into an empty working folder and say its name."""
    monkeypatch.chdir(tmp_path)

    def write(text, name="mine.toml"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        return name

    return write


def refusal(function, *arguments):
    with pytest.raises(InputError) as caught:
        function(*arguments)
    assert "\n" not in str(caught.value)
    return caught.value


class TestNames:
    def test_a_name_is_the_name_of_its_file(self, write):
        assert load_track(write(TRACK, "backyard.toml")).name == "backyard"
        assert load_track(write('name = "own"\n' + TRACK)).name == "own"

    def test_a_built_in_name_wins_over_a_file_or_folder_of_that_name(self, write):
        write("nonsense", "circle")
        assert len(load_track("circle").gates) == 12

    def test_a_file_without_an_ending_is_a_path_when_it_exists(self, write):
        assert load_track(write(TRACK, "backyard")).name == "backyard"

    def test_an_unknown_name_lists_what_there_is(self):
        with pytest.raises(UnknownNameError, match="did you mean hummingbird"):
            load_quadrotor("humingbird")

    @pytest.mark.parametrize("name", ["", ".", "nope", "x" * 5000, "\0", "~nobody-here/x.toml", "no/where.toml", "/dev/null", "/"])
    def test_no_odd_name_gets_through(self, name):
        refusal(load_quadrotor, name)


class TestBase:
    def test_a_base_supplies_what_is_not_said(self, write):
        quadrotor = load_quadrotor(write('base = "hummingbird"\nmass = 0.8\n'))
        assert quadrotor.mass == 0.8
        assert quadrotor.arm == load_quadrotor("hummingbird").arm

    def test_name_and_provenance_are_the_files_own(self, write):
        quadrotor = load_quadrotor(write('base = "hummingbird"\n', "heavy.toml"))
        assert (quadrotor.name, quadrotor.provenance) == ("heavy", "")

    def test_tables_merge_key_by_key_and_lists_replace(self, write):
        race = load_race(write('base = "split-s"\n[planning.ramp]\ndistance = 10.0\n[controller]\nrates = [1, 2, 3]\n'))
        base = load_race("split-s")
        assert race.planning.ramp is not None
        assert base.planning.ramp is not None
        assert race.planning.ramp.distance == 10
        assert race.planning.ramp.rate == base.planning.ramp.rate
        assert race.controller.rates == (1, 2, 3)
        assert race.controller.thrust == base.controller.thrust

    def test_a_default_is_not_inherited_as_if_it_had_been_said(self, write):
        write(RACE, "plain.toml")
        assert load_race(write('base = "plain.toml"\n[judge]\nrule = "released"\n')).judge.distance == 1.2

    def test_a_race_that_builds_on_another_with_its_own_vehicle_has_the_thrust_bound_of_that(self, write):
        race_file = write(RACE, "plain.toml")
        race = load_race(write('base = "plain.toml"\nvehicle = "flightmare"\n'))
        assert race.controller.thrust[1] == race.vehicle.max_acceleration != load_race(race_file).controller.thrust[1]

    def test_files_that_build_on_each_other_in_a_circle_are_refused(self, write):
        write('base = "b.toml"', "a.toml")
        write('base = "a.toml"', "b.toml")
        error = refusal(load_quadrotor, "a.toml")
        assert (error.source, error.key) == ("b.toml", "base")
        assert "a.toml -> b.toml -> a.toml" in error.reason

    def test_a_fault_in_the_base_is_reported_there(self, write):
        write(QUADROTOR.replace("0.85", "700"), "heavy.toml")
        error = refusal(load_quadrotor, write('base = "heavy.toml"'))
        assert (error.source, error.key) == ("heavy.toml", "mass")


class TestRaceReferences:
    def test_a_quadrotor_may_be_a_name_a_path_or_a_table(self, write):
        write(QUADROTOR, "racer.toml")
        by_path = load_race(write('track = "circle"\nvehicle = "racer.toml"\n'))
        inline = load_race(write(f'track = "circle"\n[vehicle]\nname = "racer"\n{QUADROTOR}'))
        changed = load_race(write('track = "circle"\nvehicle = { base = "racer.toml", delay = 0.02 }\n'))
        assert by_path.vehicle == inline.vehicle == load_quadrotor("racer.toml")
        assert changed.vehicle == by_path.vehicle.model_copy(update={"delay": 0.02})

    def test_paths_start_at_the_races_folder_then_at_the_working_folder(self, write):
        write(TRACK, "tracks/near.toml")
        write(TRACK.replace("4", "7"), "near.toml")
        write(TRACK, "far.toml")
        write('track = "near.toml"\nvehicle = "airsim"\n', "tracks/one.toml")
        write('track = "far.toml"\nvehicle = "airsim"\n', "tracks/two.toml")
        assert load_race("tracks/one.toml").track.gates[1].position[0] == 4
        assert load_race("tracks/two.toml").track.name == "far"

    def test_with_a_base_a_table_changes_and_a_name_replaces(self, write):
        base = load_race("circle-34")
        changed = load_race(write('base = "circle-34"\nvehicle = { delay = 0.02 }\n')).vehicle
        assert changed == base.vehicle.model_copy(update={"delay": 0.02})
        assert load_race(write('base = "circle-34"\nvehicle = "airsim"\n')).vehicle == load_quadrotor("airsim")
        own = load_race(write('base = "circle-34"\n[planning.quadrotor]\nbase = "hummingbird"\nmass = 0.7\n')).planning.quadrotor
        assert own == load_quadrotor("hummingbird").model_copy(update={"mass": 0.7})

    def test_a_track_may_be_a_table(self, write):
        race = load_race(write('base = "circle-34"\ntrack = { base = "circle", floor = -3.0 }\n'))
        assert race.track == load_track("circle").model_copy(update={"floor": -3.0})

    def test_a_race_reads_the_same_track_bit_for_bit(self):
        assert load_race("qualifier-20").track.fingerprint == load_track("qualifier").fingerprint

    def test_a_broken_reference_is_the_races_fault(self, write):
        error = refusal(load_race, write('track = "circl"\nvehicle = "airsim"\n'))
        assert (error.source, error.key) == ("mine.toml", "track")


FAULTS = [
    (load_quadrotor, QUADROTOR.replace("0.85", "700"), "mass", "did you mean 0.7?"),
    (load_quadrotor, QUADROTOR.replace("0.85", "nan"), "mass", "finite"),
    (load_quadrotor, QUADROTOR.replace("0.85", "inf"), "mass", "finite"),
    (load_quadrotor, QUADROTOR.replace("0.85", "-1"), "mass", "greater than 0, not -1"),
    (load_quadrotor, QUADROTOR.replace("0.85", '"0.85"'), "mass", 'must be a number, not "0.85"'),
    (load_quadrotor, QUADROTOR.replace("0.85", "true"), "mass", "must be a number, not true"),
    (load_quadrotor, QUADROTOR.replace("0.85", "2020-01-01"), "mass", "must be a number"),
    (load_quadrotor, QUADROTOR.replace("mass", "mas"), "mas", "did you mean mass?"),
    (load_quadrotor, QUADROTOR.replace("mass = 0.85\n", ""), "mass", "is missing; it is needed: [kg]"),
    (load_quadrotor, QUADROTOR.replace("1.7e-3", "3e-3"), "inertia", "no body has"),
    (load_quadrotor, QUADROTOR.replace("1e-3, 1e-3, 1.7e-3", "1e-3"), "inertia", "must have 3 values, not 1"),
    (load_quadrotor, QUADROTOR + "drag = [0, 0, 0, 0]\n", "drag", "must have 3 values, not 4"),
    (load_quadrotor, QUADROTOR + "drag = [0, -1, 0]\n", "drag[1]", "at least 0, not -1"),
    (load_quadrotor, QUADROTOR + 'layout = "z"\n', "layout", 'must be "x" or "plus", not "z"'),
    (load_quadrotor, QUADROTOR + "base = 3\n", "base", "must be a name or a path, not 3"),
    (load_quadrotor, 'base = "mine.toml"', "base", "refers back to itself"),
    (load_quadrotor, 'base = "other.toml"', "base", "there is no file other.toml"),
    (load_track, TRACK.replace("[[1, 2, 3], [4, 5, 6]]", "[]"), "gates", "at least one"),
    (load_track, TRACK.replace("[4, 5, 6]", "[1, 2, 3]"), "gates[1]", "gate 2 is at the same point as gate 1"),
    (load_track, TRACK.replace("[4, 5, 6]", "[4, 5]"), "gates[1].position", "must have 3 values, not 2"),
    (load_track, TRACK.replace("[4, 5, 6]", "[4, nan, 6]"), "gates[1].position[1]", "finite"),
    (load_track, TRACK.replace("[4, 5, 6]", "{ positon = [4, 5, 6] }"), "gates[1].positon", "did you mean position?"),
    (load_track, TRACK.replace("[4, 5, 6]", "4"), "gates[1]", "must be a table, not 4"),
    (load_track, TRACK + "attitude = [1, 1, 0, 0]", "attitude", "norm 1"),
    (load_track, TRACK + "floor = 2.0", "floor", "lies above the start"),
    (load_track, "gates = 5\nstart", "", "is not valid TOML"),
    (load_track, "x = " + "[" * 5000, "", "is nested too deeply"),
    (load_track, TRACK + "opening" + ".a" * 300 + " = 1", "line 3", "is nested too deeply"),
    (load_track, TRACK + "laps = 0x" + "f" * 5000, "laps", "must be a whole number of at most 64 bits"),
    (load_track, TRACK + '"a\\nb" = 1', "a\nb", "there is no such key"),
    (load_track, "#" * 1_000_001, "", "is larger than 1 MB"),
    (load_race, RACE + 'tracks = "circle"', "tracks", "did you mean track?"),
    (load_race, RACE.replace('"hummingbird"', "5"), "vehicle", "must be a name, a path or a table, not 5"),
    (load_race, RACE.replace('"hummingbird"', "{ mass = 1 }"), "vehicle.inertia", "is missing"),
    (load_race, RACE.replace('"hummingbird"', '{ base = "nope" }'), "vehicle.base", "there is no quadrotor"),
    (load_race, RACE.replace('"hummingbird"', '{ base = "airsim", dely = 1 }'), "vehicle.dely", "did you mean delay?"),
    (load_race, RACE + '[planning.quadrotor]\nbase = "airsim"\nmass = 700', "planning.quadrotor.mass", "did you mean 0.7?"),
    (load_race, RACE + "planning = 5", "planning", "must be a table, not 5"),
    (load_race, RACE + "[planning]\nquadrotor = { base = 5 }", "planning.quadrotor.base", "must be a name or a path"),
    (load_race, RACE + '[judge]\nrule = "x"', "judge.rule", '"clock", "closest", "opening" or "released"'),
    (load_race, RACE + "[controller]\nperiod = 0.003", "controller.period", "a multiple"),
    (load_race, RACE + "[controller]\nnodes = 5.5", "controller.nodes", "whole number"),
    (load_race, RACE + "[controller]\nfeed_forward = 1", "controller.feed_forward", "true or false"),
    (load_race, 'base = "circle-34"\n[noise]\nthrst = 1', "noise.thrst", "did you mean thrust?"),
    (load, "a = 1", "", "is neither a race"),
]


@pytest.mark.parametrize(("function", "text", "key", "reason"), FAULTS, ids=[f"{key}-{reason[:20]}" for _, _, key, reason in FAULTS])
def test_a_fault_is_one_line_with_file_key_and_reason(write, function, text, key, reason):
    error = refusal(function, write(text))
    assert (error.source, error.key) == ("mine.toml", key)
    assert reason in error.reason


def test_several_faults_are_counted(write):
    error = refusal(load_quadrotor, write(QUADROTOR.replace("0.85", "-1").replace("0.15", "-1") + "delay = -1"))
    assert error.reason == "must be greater than 0, not -1 (and 2 more faults: arm, delay)"


def test_what_is_no_text_is_refused(write):
    path = write("")
    with open(path, "wb") as file:  # noqa: PTH123 - a name, not a Path
        file.write(b"mass = \xff")
    assert "UTF-8" in refusal(load_quadrotor, path).reason


def test_a_folder_is_no_file(tmp_path):
    assert "is a folder" in refusal(load_quadrotor, f"{tmp_path}/").reason


junk = st.booleans() | st.integers() | st.floats() | st.text(st.characters(exclude_categories=["Cs"]), max_size=5)
junk = st.recursive(
    junk, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["base", "mass", "x"]), inner, max_size=2)
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(kind=st.sampled_from(list(Kind)), data=st.data())
def test_junk_in_any_key_is_either_understood_or_refused(write, kind, data):
    keys = [key.name for key in documented_keys(TYPES[kind])] + ["base", "zzz"]
    table = data.draw(st.dictionaries(st.sampled_from(keys), junk, max_size=5))
    valid = {Kind.RACE: RACE, Kind.TRACK: TRACK, Kind.QUADROTOR: QUADROTOR}[kind]
    path = write(toml_writer.write({**tomllib.loads(valid), **table}))
    try:
        description = descriptions.load(path)
    except InputError as error:
        understood, refused = None, str(error)
    else:
        understood, refused = description, ""
    assert isinstance(understood, tuple(TYPES.values())) or (refused and "\n" not in refused)


@given(st.sampled_from([key.name for key in documented_keys(TYPES[Kind.QUADROTOR])]), st.sampled_from("xyz_"))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_misspelt_key_is_named(write, name, letter):
    error = refusal(load_quadrotor, write(f'base = "hummingbird"\n{name + letter} = 1\n'))
    assert error.key == name + letter
    assert "there is no such key" in error.reason


def test_a_saved_track_has_its_gates_as_a_person_writes_them(write, tmp_path):
    gates = "gates = [\n  [1.0, 2.0, 3.0],\n  { position = [4.0, 5.0, 6.0], yaw = 0.0, side = 1.5 },\n]\n"
    track = load_track(write("start = [0, 0, 0]\n" + gates))
    save(tmp_path / "again.toml", track)
    assert gates in (tmp_path / "again.toml").read_text()


@pytest.mark.parametrize("kind", list(Kind))
def test_a_saved_description_reads_back_equal(kind, tmp_path):
    for name in names(kind):
        description = load(name) if kind is Kind.RACE else {Kind.TRACK: load_track, Kind.QUADROTOR: load_quadrotor}[kind](name)
        path = tmp_path / f"{name}.toml"
        save(path, description)
        assert load(path).fingerprint == description.fingerprint


@given(st.lists(st.tuples(*[st.floats(-1e4, 1e4)] * 3), min_size=2, max_size=4, unique=True))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_coordinates_survive_a_file_bit_for_bit(write, points):
    if min(np.linalg.norm(np.diff(points, axis=0), axis=1)) < 1e-3:
        return
    path = write(toml_writer.write({"start": points[0], "gates": points[1:]}))
    track = load_track(path)
    assert (track.start, *(gate.position for gate in track.gates)) == tuple(points)


def test_the_kind_of_a_file_is_told_by_its_keys(write):
    assert type(load(write(TRACK))).__name__ == "Track"
    assert type(load(write(QUADROTOR))).__name__ == "Quadrotor"
    assert type(load(write(RACE))).__name__ == "Race"
    assert type(load(write('base = "circle-34"\n'))).__name__ == "Race"


def test_create_never_overwrites(tmp_path):
    path = tmp_path / "new.toml"
    create(path, "a = 1\n")
    assert "exists already" in refusal(create, path, "b = 2\n").reason
    assert path.read_text() == "a = 1\n"


def test_writing_where_nothing_can_be_written_is_one_line(tmp_path):
    refusal(create, tmp_path / "no" / "new.toml", "")
    refusal(save, tmp_path / "no" / "new.toml", load_track("circle"))


def test_the_rule_of_the_airsim_suite_comes_with_its_base():
    assert load_race("airsim-flip-16").judge.rule is GateRule.CLOSEST


def test_keys_of_before_go_on_working_and_one_line_says_the_new_ones(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('base = "circle-34"\n[controller]\nhandover = "distance"\nhandover_distance = 3.0\n')
    with pytest.warns(RenamedWarning, match=r"mine\.toml: controller\.handover(_distance)? is now called segment_switch") as said:
        race = load_race(path)
    assert len(said) == 2
    assert (race.controller.segment_switch, race.controller.segment_switch_distance) == ("distance", 3.0)


def test_a_key_under_both_its_names_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('base = "circle-34"\n[controller]\nhandover = "distance"\nsegment_switch = "node"\n')
    with pytest.raises(InputError, match=r"mine\.toml: controller\.handover: is now called segment_switch, which is there too"):
        load_race(path)
