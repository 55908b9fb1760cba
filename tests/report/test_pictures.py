"""Whatever a study has come to, it can be drawn; nothing half-written is left, nothing global is changed."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from fake_world import make_scenario
from hotlap.analysis.sensitivity import survey_sensitivity
from hotlap.core.errors import InputError
from hotlap.core.records import End, Log
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.report import figures, pictures
from hotlap.report.canvas import CLASS_CODES
from hotlap.report.history import collect, compare, recount
from hotlap.report.page.replay import choose, demonstrate
from hotlap.report.pictures import FORMATS, draw, draw_everything, draw_plan, figures_of, save
from hotlap.report.scene import stage
from hotlap.report.style import CLASS_COLOURS, styled
from hotlap.study.configuration import Configuration
from hotlap.study.study import Study
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric
from plausible_world import OPTIMUM, PlausibleWorld
from studies import begin, carry, configure

NAMES = ("track", "convergence", "error", "parameters")
SIGNATURES = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}


def draw_study(folder: Path, world=None, scenario: Scenario | None = None, goal: str = "completion=1", budget: int = 20):
    """Run a small study, draw it, and return the files."""
    scenario, world = scenario or make_scenario(), world or PlausibleWorld()
    settings = TuningSettings(seed=3, budget=budget, goal=parse_goal(goal), validation=20)
    guess = scenario.space.first_guess(len(scenario.segments))
    configuration = Configuration(scenario, world.name, parse_goal(goal).metric, "metropolis_hastings:tied", settings, guess)
    with Study.open(folder, configuration) as study:
        if budget > 1 or goal != "unflown":
            study.run(Objective(scenario, world, configuration.metric))
        return draw(folder, study, world, flights=4)


def check(folder: Path, files) -> None:
    assert [path.name for path in files] == [f"{name}.png" for name in NAMES]
    assert all(path.read_bytes().startswith(SIGNATURES["png"]) for path in files)
    assert not list(folder.glob("*.part"))


@pytest.mark.check
@pytest.mark.parametrize(
    ("world", "goal", "budget"),
    [
        (PlausibleWorld(), "completion=1", 20),
        (PlausibleWorld(reach=20.0), "completion=1", 20),  # fails all the time
        (PlausibleWorld(reach=40.0, crash=True), "none", 12),
        (PlausibleWorld(reach=0.0, noise=0.0), "completion=1", 20),  # the first guess is the best
        (PlausibleWorld(), "none", 1),  # one flight
        (PlausibleWorld(), "mean_error<0.01", 12),
        (PlausibleWorld(noise=1.5), "completion=1", 30),  # re-flights fail
    ],
)
def test_any_study_can_be_drawn(tmp_path, world, goal, budget):
    check(tmp_path, draw_study(tmp_path, world, goal=goal, budget=budget))


@pytest.mark.check
def test_a_single_segment_can_be_drawn(tmp_path):
    scenario = make_scenario()
    scenario = replace(scenario, segments=Segments(np.zeros(1), (SegmentClass.STEEP,), scenario.reference.duration))
    check(tmp_path, draw_study(tmp_path, scenario=scenario))


@pytest.mark.check
def test_many_segments_can_be_drawn(tmp_path):
    scenario = make_scenario()
    kinds = tuple(SegmentClass) * 6
    starts = np.arange(len(kinds)) * scenario.reference.duration / len(kinds)
    scenario = replace(scenario, segments=Segments(starts, kinds, scenario.reference.duration))
    check(tmp_path, draw_study(tmp_path, scenario=scenario))


@pytest.mark.check
def test_segments_of_several_pieces_can_be_drawn(tmp_path):
    scenario, kinds = make_scenario(), (SegmentClass.ASCENT, SegmentClass.STEEP, SegmentClass.ASCENT)
    segments = Segments(np.array([0.0, 1.0, 2.5]), kinds, scenario.reference.duration, (0, 1, 0))
    scenario = replace(scenario, segments=segments)
    check(tmp_path, draw_study(tmp_path, scenario=scenario))
    draw_plan(tmp_path / "plan.png", scenario)
    change = compare(scenario.space, segments, scenario.space.first_guess(2), np.tile(OPTIMUM, (2, 1)), 0.5)
    named = texts(figures.tuned_parameters(change, "straight"))
    assert "ascent  3.5 s" in named
    assert "steep  1.0–2.5 s" in named


def test_every_class_has_a_colour():
    assert set(CLASS_COLOURS) == set(CLASS_CODES) == set(SegmentClass)


@pytest.mark.check
def test_the_rule_closest_can_be_drawn(tmp_path):
    check(tmp_path, draw_study(tmp_path, scenario=make_scenario(JudgeSettings(rule=GateRule.CLOSEST, fly_on=True))))


@pytest.mark.check
def test_a_study_without_flights_can_be_drawn(tmp_path):
    scenario = make_scenario()
    configuration = Configuration(
        scenario, "plausible", Metric.TIME, "metropolis_hastings:tied", TuningSettings(), scenario.space.first_guess(2)
    )
    with Study.open(tmp_path, configuration) as study:
        check(tmp_path, draw(tmp_path, study, PlausibleWorld(), flights=1))


class LostWorld(PlausibleWorld):
    """Its flights end at once, nowhere, with a log of one row or none."""

    def __init__(self, rows: int) -> None:
        super().__init__(reach=40.0, crash=True)
        self.rows = rows

    def fly(self, *args, **kwargs):
        flights = super().fly(*args, **kwargs)
        nowhere, none = np.full_like(flights.end_position, np.nan), np.full_like(flights.clock_distance, np.nan)
        logs = {i: Log(*(None if row is None else row[: self.rows] for row in vars(log).values())) for i, log in flights.logs.items()}
        ends, zeros = np.full_like(flights.end, int(End.CRASHED)), np.zeros_like(flights.gates_passed)
        return replace(flights, logs=logs, end=ends, gates_passed=zeros, end_position=nowhere, clock_distance=none, closest_time=none)


@pytest.mark.check
@pytest.mark.parametrize("rows", [0, 1])
def test_flights_that_leave_no_trace_can_be_drawn(tmp_path, rows):
    check(tmp_path, draw_study(tmp_path, LostWorld(rows), goal="none", budget=4))


@pytest.mark.check
def test_drawing_again_replaces_the_pictures(tmp_path):
    first = [path.read_bytes() for path in draw_study(tmp_path)]
    assert [path.read_bytes() for path in draw_study(tmp_path)] == first


class WatchedWorld(PlausibleWorld):
    """Remembers what it was asked for."""

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        self.asked = parameters, seeds, list(log)
        return super().fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters, log=log)


def test_best_and_first_guess_meet_the_same_noise_of_the_demonstration():
    scenario, world, seeds = make_scenario(), WatchedWorld(), flight_seeds(3, Stream.DEMONSTRATION, 0, 4)
    first, best = scenario.space.first_guess(2), np.tile(OPTIMUM, (2, 1))
    scene = demonstrate(scenario, world, choose(scenario, first, best), seeds)
    parameters, flown, log = world.asked
    np.testing.assert_array_equal(flown, np.tile(seeds, 2))
    np.testing.assert_array_equal(parameters, np.concatenate([[best] * 4, [first] * 4]))
    assert log == [0, 1, 2, 3, 4, 5, 6, 7]
    assert [flight.label for flight in scene.traces] == ["tuned", "first guess"]


def test_a_first_guess_that_is_the_best_is_flown_once():
    scenario, world = make_scenario(), WatchedWorld()
    guess = scenario.space.first_guess(2)
    scene = demonstrate(scenario, world, choose(scenario, guess, guess.copy()), np.arange(4))
    assert len(world.asked[1]) == 4
    assert [flight.label for flight in scene.traces] == ["tuned"]


def test_a_guess_that_is_not_the_default_has_the_default_beside_it():
    scenario, guess = make_scenario(), np.tile(OPTIMUM, (2, 1))
    assert [one.label for one in choose(scenario, guess, guess.copy())] == ["tuned", "default"]
    assert [one.label for one in choose(scenario, guess, 2 * guess)] == ["tuned", "first guess", "default"]


def show(scenario, reach, count):
    """A good flight, and a bad one of the first guess."""
    best = np.tile(OPTIMUM, (2, 1))
    return demonstrate(scenario, PlausibleWorld(reach=reach), choose(scenario, scenario.space.first_guess(2), best), np.arange(count))


@pytest.mark.check
@pytest.mark.parametrize("suffix", FORMATS)
def test_a_plan_is_drawn_in_the_format_of_its_suffix(tmp_path, suffix):
    path = tmp_path / f"plan.{suffix}"
    draw_plan(path, make_scenario())
    assert path.read_bytes().startswith(SIGNATURES[suffix])
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("name", ["plan.gif", "plan", "plan.toml", ".png"])
def test_another_suffix_is_refused(tmp_path, name):
    with pytest.raises(InputError, match=r"\.png, \.svg, \.pdf"):
        draw_plan(tmp_path / name, make_scenario())
    assert not list(tmp_path.iterdir())


def test_a_picture_that_cannot_be_written_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        draw_plan(tmp_path / "nowhere" / "plan.png", make_scenario())


@pytest.mark.check
def test_a_plan_stands_on_end_or_on_a_point(tmp_path):
    scenario = make_scenario()
    for k, shape in enumerate(([0, 0, 1.0], [0, 0, 0.0], [0, 1.0, 0])):
        position = scenario.reference.position[:, :1] * shape
        draw_plan(tmp_path / f"{k}.png", replace(scenario, reference=replace(scenario.reference, position=position)))


def test_settings_of_the_user_are_left_alone():
    with mpl.rc_context({"axes.grid": True, "font.size": 30.0, "backend": "agg"}):
        before = mpl.rcParams.copy()
        figures.track(stage(make_scenario()))
        assert mpl.rcParams == before


@pytest.mark.check
def test_settings_of_the_user_change_no_picture(tmp_path):
    draw_plan(tmp_path / "plain.png", make_scenario())
    with mpl.rc_context({"axes.grid": True, "font.size": 30.0, "lines.linewidth": 9, "savefig.dpi": 20, "savefig.bbox": "tight"}):
        draw_plan(tmp_path / "odd.png", make_scenario())
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "odd.png").read_bytes()


def test_no_figure_is_left_to_pyplot():
    figures.track(stage(make_scenario()))
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or not pyplot.get_fignums()


@pytest.mark.check
def test_nothing_below_loads_matplotlib():
    code = "import hotlap, hotlap.study.study, hotlap.planning, hotlap.reference.segmentation, sys; sys.exit('matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_styled_function_keeps_its_name():
    @styled
    def sketch() -> Figure:
        return Figure()

    assert sketch.__name__ == "sketch"


def texts(figure: Figure) -> str:
    figure.draw_without_rendering()
    return " ".join(text.get_text() for text in figure.findobj(mpl.text.Text))


@pytest.mark.check
def test_every_axis_has_its_unit():
    scenario = make_scenario()
    scene = show(scenario, 20.0, 4)
    assert all(words in texts(figures.track(scene)) for words in ("x [m]", "y [m]", "z [m]", "m/s", "start", "first guess"))
    error = texts(figures.tracking_error(scene))
    assert all(words in error for words in ("time [s]", "distance [m]", "1.3 m", "flat", "ascent", "missed gate"))


@pytest.mark.check
def test_parameters_show_values_and_bounds():
    scenario = make_scenario()
    change = compare(scenario.space, scenario.segments, scenario.space.first_guess(2), np.tile(OPTIMUM, (2, 1)), 0.5)
    figure = figures.tuned_parameters(change, "straight")
    assert all(words in texts(figure) for words in (*change.names, "80", "400", "4.5", "× 0.5 s", "flat", "ascent", "1500"))


def test_marks_that_do_not_occur_are_not_explained(tmp_path):
    scenario = make_scenario()
    configuration = Configuration(
        scenario, "plausible", Metric.TIME, "metropolis_hastings:tied", TuningSettings(), scenario.space.first_guess(2)
    )
    with Study.open(tmp_path, configuration) as study:
        figure = figures.convergence(recount(study.flights(), parse_goal("none"), "cost [s]"), "straight")
    assert not any(words in texts(figure) for words in ("passed", "missed", "re-flight", "kept"))


@pytest.mark.check
def test_the_flight_that_was_kept_is_marked_in_both_charts(tmp_path):
    study = carry(tmp_path, configure())
    history = recount(study.ledger, study.configuration.settings.goal, "cost [s]", study.best)
    shown = texts(figures.convergence(history, "straight"))
    assert "tuned: kept" in shown
    assert "passed the goal" in shown
    found = collect(study.ledger, study.configuration.settings.goal)
    pairs = texts(figures.samples(found, study.configuration.scenario.space, study.best, "straight"))
    assert all(words in pairs for words in ("passed the goal", "failed the goal", "tuned: kept"))


def test_a_figure_of_one_file_is_saved_whole(tmp_path):
    figure = Figure()
    assert save(tmp_path / "empty.PNG", figure) == tmp_path / "empty.PNG"


@pytest.mark.check
def test_failures_are_shown_without_repeats_as_well():
    scenario = make_scenario()
    scene = show(scenario, 20.0, 4)
    assert "failed flights" in texts(figures.track(scene))
    assert "failed flights" in texts(figures.track(replace(scene, repeats=())))
    assert "failed flights" not in texts(figures.track(replace(scene, repeats=(), traces=scene.traces[:1])))


def test_an_error_above_the_chart_is_written():
    scenario = make_scenario()
    scene = show(scenario, 60.0, 1)
    assert scene.traces[1].error[-1] > 2.3
    assert f"at {scene.traces[1].error[-1]:.1f} m" in texts(figures.tracking_error(scene))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return carry(tmp_path_factory.mktemp("study"), configure(budget=12, goal="none"))


@pytest.fixture(scope="module")
def everything(study):
    """Every figure of a study, drawn once."""
    return figures_of(study, PlausibleWorld(), flights=4)


@pytest.mark.check
def test_every_figure_of_a_study_is_saved_under_its_name(study, everything, tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "figures_of", lambda *_: everything)
    with Study.read(study.folder) as read:
        files = draw_everything(tmp_path, read, PlausibleWorld(), "png")
    assert [path.name for path in files] == [f"{name}.png" for name in (*NAMES, "inputs", "sensitivity", "samples")]
    assert all(path.read_bytes().startswith(SIGNATURES["png"]) for path in files)


@pytest.mark.check
@pytest.mark.parametrize("kind", sorted({*FORMATS} - {"png"}))
def test_every_figure_has_every_format(everything, kind, tmp_path):
    for name, figure in everything.items():
        assert save(tmp_path / f"{name}.{kind}", figure).read_bytes().startswith(SIGNATURES[kind])


@pytest.mark.check
def test_everything_of_a_study_without_flights_is_drawn(tmp_path):
    drawn = figures_of(begin(tmp_path, configure()), PlausibleWorld(crash=True), flights=1)
    assert len(drawn) == 7
    assert all(texts(figure) for figure in drawn.values())


def test_inputs_have_their_units_and_limits_and_say_how_long_they_are_at_one():
    scenario = make_scenario()
    scene = show(scenario, 20.0, 2)
    commands = np.tile([scenario.race.controller.thrust[1], 0, 0, 0], (len(scene.traces[0].times), 1))
    scene = replace(scene, traces=(replace(scene.traces[0], commands=commands), *scene.traces[1:]))
    drawn = texts(figures.inputs(scene, scenario))
    assert all(words in drawn for words in ("[m/s²]", "[rad/s]", "[N]", "rotor 3", "100 % of the time", "0 % of the time"))


def test_samples_and_sensitivity_name_every_parameter(study, everything):
    for name in ("samples", "sensitivity"):
        drawn = texts(everything[name])
        assert all(parameter in drawn for parameter in study.configuration.scenario.space.names)


def test_where_completion_tells_nothing_sensitivity_is_in_cost_as_on_the_page(study):
    asked = study.configuration
    change = pictures._change(study)
    lost = survey_sensitivity(asked.scenario, PlausibleWorld(reach=50.0), study.best, 0)
    some = survey_sensitivity(asked.scenario, PlausibleWorld(), study.best, 0)
    flat, told = (texts(figures.sensitivity(found, change, "title", "cost [s]")) for found in (lost, some))
    assert lost.cost_tells
    assert "cost [s]" in flat
    assert "completion [%]" not in flat
    assert "completion stays at" in flat
    assert not some.cost_tells
    assert "completion [%]" in told
    assert "cost" not in told
