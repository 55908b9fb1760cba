"""What may be asked on the command line: every command with its arguments; imports nothing that takes time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from hotlap.cli.parser import Parser, fraction, one_of, path, whole
from hotlap.core.success_rate import RELIABILITY

KINDS = ("race", "track", "quadrotor")
RULES = ("paper", "released_1m", "released_3m", "none", "equal_time")
EXPORTS = ("rpg_mpc", "acados", "json", "toml", "csv", "optuna")
GUESSES = ("learned", "paper", "default")
REPRODUCED = Path("runs/reproduced")
EXPERIMENTS = ("table1", "table2", "table3", "landscape", "experts", "robustness", "initialisations")
PICTURES = ("png", "pdf", "svg")
GOALS = "completion=1, completion=0.95, mean_error<0.3, max_error<1.0 or none"


@dataclass(frozen=True)
class Command:
    """A command of `hotlap`.

    Attributes:
        summary: one sentence that says what it does.
        add: adds its arguments to a parser.
        examples: how it is called.
        purpose: one clause for the list of commands.
    """

    purpose: str
    summary: str
    add: Callable[[Parser], None]
    examples: tuple[str, ...]

    def parser(self, name: str) -> Parser:
        """A parser of its arguments."""
        parser = Parser(f"hotlap {name}", self.summary, self.examples)
        self.add(parser)
        parser.add_argument("--json", action="store_true", help="print one JSON document instead of text for people")
        return parser


def _race(parser: Parser) -> None:
    parser.add_argument("race", metavar="RACE", help="a built-in race (hotlap races) or a TOML file")


def _study(parser: Parser) -> None:
    parser.add_argument("study", type=path, metavar="DIR", help="folder of a study, as hotlap tune makes it")


def _reference(parser: Parser) -> None:
    parser.add_argument("--reference", type=path, metavar="FILE", help="read this CSV instead of planning")


def _world(parser: Parser) -> None:
    parser.add_argument("--on", default="built-in", metavar="WORLD", help="where to fly (default: built-in)")


def _controller(parser: Parser) -> None:
    kinds = one_of("controller", ("mpc", "mpc_drag", "geometric"))
    parser.add_argument("--controller", type=kinds, metavar="KIND", help="mpc, mpc_drag or geometric (default: the race's)")


def _segments(parser: Parser) -> None:
    rules = one_of("segmentation rule", RULES)
    parser.add_argument("--segments", type=rules, default=RULES[0], metavar="RULE", help=f"{', '.join(RULES)} (default: {RULES[0]})")


def _first_guess(parser: Parser, default: str, purpose: str) -> None:
    known = f"{', '.join(GUESSES)}, parameters (a file or a study's folder), or what was learnt (a .json)"
    parser.add_argument("--first-guess", default=default, metavar="NAME", help=f"{purpose}: {known} (default: {default})")


def _races(parser: Parser) -> None:  # noqa: ARG001  it takes none
    return


def _check(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE", help="a TOML file, or the name of a built-in race, track or quadrotor")


def _new(parser: Parser) -> None:
    parser.add_argument("kind", metavar="KIND", type=one_of("kind of file", KINDS), help=", ".join(KINDS))
    parser.add_argument("name", metavar="NAME", help="what it is called; the file is NAME.toml")
    parser.add_argument("--track", metavar="TRACK", help="of a race: a built-in track or a TOML file (default: circle)")
    parser.add_argument("--vehicle", metavar="QUADROTOR", help="of a race: a built-in quadrotor or a TOML file (default: a hummingbird)")


def _plan(parser: Parser) -> None:
    _race(parser)
    parser.add_argument("--out", type=path, metavar="FILE", help="write the reference as CSV")
    parser.add_argument("--picture", type=path, metavar="FILE", help="draw it: .png, .svg or .pdf")
    _reference(parser)
    _segments(parser)
    parser.add_argument("--no-cache", action="store_true", help="plan anew, and keep nothing in the cache of plans")


def _tune(parser: Parser) -> None:
    _race(parser)
    add = parser.add_argument
    add("--tuner", default="gate_gp", metavar="NAME", help="NAME, NAME:PRESET or my_module.MyTuner (default: gate_gp)")
    add("--goal", default="completion=1", help=f"when to stop: {GOALS}; or lap_time: the fastest plan that holds (default: completion=1)")
    add("--budget", type=whole, default=200, metavar="N", help="flights at most, re-flights included (default: 200)")
    add("--seed", type=whole, default=0, metavar="S", help="of the search and of the noise (default: 0)")
    add("--out", type=path, metavar="DIR", help="folder of the study, begun or gone on with (default: runs/RACE-DATE, new)")
    _reference(parser)
    _segments(parser)
    _first_guess(parser, "learned", "what to begin with")
    _controller(parser)
    _world(parser)
    add("--randomise", type=fraction, default=0.0, metavar="R", help="fly in worlds that differ from the vehicle by up to this share")
    add("--samples", type=whole, default=0, metavar="N", help="flights of each candidate, all to succeed (default: 1; randomised: 4)")
    add("--confirm", type=whole, default=10, metavar="N", help="re-flights that a candidate must pass (default: 10; the paper's: 4)")
    add("--validation", type=whole, default=200, metavar="N", help="flights of the result with fresh noise, 0 for none (default: 200)")
    add(
        "--reliability",
        type=fraction,
        default=RELIABILITY,
        metavar="R",
        help=f"least share of these to succeed (default: {RELIABILITY:g}; 0: any)",
    )
    add("--batch", type=whole, default=8, metavar="N", help="most candidates to fly at once, for tuners that can (default: 8)")


def _fly(parser: Parser) -> None:
    _race(parser)
    add = parser.add_argument
    add("--parameters", type=path, metavar="FILE", help="a parameters file or a study's folder")
    _first_guess(parser, "default", "without --parameters, what is flown")
    add("--flights", type=whole, default=100, metavar="N", help="how many, each with noise of its own (default: 100)")
    add("--seed", type=whole, default=0, metavar="S", help="of the noise (default: 0)")
    _reference(parser)
    _segments(parser)
    _controller(parser)
    _world(parser)
    add("--log", type=path, metavar="FILE", help="write the first flight as CSV, step by step")


def _report(parser: Parser) -> None:
    add = parser.add_argument
    _study(parser)
    add("--figures", action="store_true", help="draw every figure of the page as well, each into a file of its own")
    formats = one_of("format", PICTURES)
    add(
        "--format",
        type=formats,
        default=PICTURES[0],
        metavar="NAME",
        help=f"of the figures: {', '.join(PICTURES)} (default: {PICTURES[0]})",
    )
    add("--video", type=path, metavar="FILE", help="the flight as a moving picture: .gif or .mp4")


def _watch(parser: Parser) -> None:
    _study(parser)
    add = parser.add_argument
    add("--port", type=whole, default=0, metavar="N", help="to listen on (default: 0, any that is free)")
    add("--host", default="127.0.0.1", metavar="NAME", help="to listen on (default: 127.0.0.1, this machine alone)")


def _compare(parser: Parser) -> None:
    add = parser.add_argument
    add("races", nargs="+", metavar="RACE", help="built-in races (hotlap races) or TOML files")
    names = "gate_gp,metropolis_hastings,cma_es,random_search"
    add("--tuners", default=names, metavar="A,B", help=f"NAME, NAME:PRESET or my_module.MyTuner of each (default: {names})")
    add("--seeds", type=whole, default=10, metavar="N", help="runs of each tuner on each race (default: 10)")
    add("--budget", default="200", metavar="N", help="flights of a run, re-flights included: 200,cma_es=1000 (default: 200)")
    add("--out", type=path, required=True, metavar="DIR", help="folder of the comparison, begun or gone on with")
    add("--goal", default="completion=1", help=f"when a run stops: {GOALS} (default: completion=1)")
    add("--confirm", type=whole, default=4, metavar="N", help="re-flights that a candidate must pass (default: 4)")
    add("--randomise", type=fraction, default=0.0, metavar="R", help="fly in worlds that differ from the vehicle by up to this share")
    add("--samples", type=whole, default=0, metavar="N", help="flights of each candidate, all to succeed (default: 1; randomised: 4)")
    add("--validation", type=whole, default=50, metavar="N", help="flights of each result with fresh noise (default: 50)")
    guesses = one_of("first guess", GUESSES)
    add("--first-guess", type=guesses, default="default", metavar="NAME", help=f"where all begin: {', '.join(GUESSES)} (default: default)")
    add("--jobs", type=whole, default=0, metavar="N", help="processes (default: one a processor)")
    _segments(parser)
    _controller(parser)
    _world(parser)


def _landscape(parser: Parser) -> None:
    _race(parser)
    add = parser.add_argument
    add("--x", default="Q_pos_xy", metavar="NAME", help="parameter along the map (default: Q_pos_xy)")
    add("--y", default="horizon", metavar="NAME", help="parameter across it (default: horizon)")
    add("--points", type=whole, default=50, metavar="N", help="along each, evenly in logarithms (default: 50)")
    add("--flights", type=whole, default=4, metavar="N", help="at each point, with the same noise at all (default: 4)")
    _first_guess(parser, "default", "what the other parameters are")
    _controller(parser)
    add("--out", type=path, metavar="FILE", help="draw it: .png, .svg or .pdf")


def _learn(parser: Parser) -> None:
    add = parser.add_argument
    add("races", nargs="*", metavar="RACE", help="races to learn from, of one controller (default: 135 that come with hotlap)")
    add("--out", type=path, required=True, metavar="DIR", help="folder of what is learnt, begun or gone on with")
    add("--jobs", type=whole, default=0, metavar="N", help="processes (default: one a processor)")


def _reproduce(parser: Parser) -> None:
    add = parser.add_argument
    names = one_of("experiment", (*EXPERIMENTS, "all"))
    add("experiment", metavar="NAME", type=names, help=f"{', '.join(EXPERIMENTS)} or all")
    add("--quick", action="store_true", help="the short form, under a minute each: other races, fewer seeds")
    add(
        "--out",
        type=path,
        default=REPRODUCED,
        metavar="DIR",
        help=f"folder of the pages, begun or gone on with (default: {REPRODUCED})",
    )
    add("--jobs", type=whole, default=0, metavar="N", help="processes (default: one a processor)")


def _export(parser: Parser) -> None:
    parser.add_argument("folder", metavar="DIR", type=path, help="folder of a study, as hotlap tune made it")
    formats = one_of("format", EXPORTS)
    parser.add_argument("--format", type=formats, required=True, metavar="NAME", help=", ".join(EXPORTS))
    parser.add_argument("--out", type=path, metavar="FILE", help="file to write (default: one in DIR)")


def _bench(parser: Parser) -> None:  # noqa: ARG001  it takes none
    return


COMMANDS: Mapping[str, Command] = {
    "races": Command("list the built-in races", "List the built-in races and what to expect of them.", _races, ()),
    "check": Command(
        "say what a file means",
        "Say what a track, quadrotor or race means: thrust margins, latency, limits that bind, expected difficulty.",
        _check,
        ("hotlap check my-race.toml", "hotlap check circle-34"),
    ),
    "new": Command(
        "write a file to start from",
        "Write a commented file to start from, every key with its unit and default.",
        _new,
        ("hotlap new quadrotor my-drone", "hotlap new race my-race --vehicle my-drone.toml --track circle"),
    ),
    "plan": Command(
        "plan the fastest reference",
        "Plan the minimum-time reference of a race, segment it, and write it for others to read.",
        _plan,
        ("hotlap plan circle-34 --out circle.csv --picture circle.png",),
    ),
    "tune": Command(
        "tune the controller for a race",
        "Tune the controller until the goal holds in fresh flights, validate it, and draw it. Every flight is recorded; the same\n"
        "command with --out goes on where it was interrupted. Exits with 1 when the goal was not confirmed within the budget.",
        _tune,
        ("hotlap tune circle-34", "hotlap tune my-race.toml --budget 500 --out runs/mine", 'hotlap tune split-s --goal "mean_error<0.3"'),
    ),
    "compare": Command(
        "compare tuners on equal terms",
        "Run tuners on races with the same first guess, budget, seeds and noise, and say how they did: tables, curves, a profile.\n"
        "Every run is kept when it has ended; the same command goes on where it was interrupted.",
        _compare,
        (
            "hotlap compare drop-20 flip-16 --out runs/compared",
            "hotlap compare my-race.toml --tuners gate_gp,cma_es:tied --seeds 20 --out runs/mine",
        ),
    ),
    "fly": Command(
        "fly parameters again",
        "Fly a race with given parameters and fresh noise, and say how the flights ended.",
        _fly,
        ("hotlap fly circle-34", "hotlap fly circle-34 --parameters runs/mine --flights 1000"),
    ),
    "report": Command(
        "write the page of a study again",
        "Write report.html into the folder of a study: the flight in three dimensions, what was tuned, and whether it will hold, in one\n"
        "file that needs no network. Its flights are flown again with fresh noise.",
        _report,
        ("hotlap report runs/mine", "hotlap report runs/mine --figures --format pdf", "hotlap report runs/mine --video lap.gif"),
    ),
    "watch": Command(
        "show a study in the browser while it runs",
        "Show the page of a study to browsers on this machine, and keep it up to date as flights come in, until Ctrl-C. Nothing is\n"
        "written; --json prints the address at once.",
        _watch,
        ("hotlap watch runs/mine", "hotlap watch runs/mine --port 8080"),
    ),
    "export": Command(
        "write parameters for other programs",
        "Write tuned parameters as other programs read them: mpc.yaml of rpg_mpc, weights for acados, JSON, TOML, CSV; or all flights\n"
        "of a study for optuna-dashboard.",
        _export,
        ("hotlap export runs/mine --format acados", "hotlap export runs/mine --format optuna --out flights.db"),
    ),
    "landscape": Command(
        "map completion over two parameters",
        "Fly a race over a grid of two parameters, the same in all segments, the others held.",
        _landscape,
        ("hotlap landscape circle-34 --x Q_pos_xy --y Q_velocity --out map.png",),
    ),
    "learn": Command(
        "learn first guesses from races",
        "Tune races, fly each with the parameters of all others, and keep what first guesses are learnt from. Every race is kept when\n"
        "it is done; the same command goes on where it was interrupted.",
        _learn,
        ("hotlap learn my-race.toml my-other-race.toml --out runs/learnt", "hotlap learn --out runs/learnt"),
    ),
    "reproduce": Command(
        "repeat the paper's experiments",
        "Repeat the tables and figures of AutoTune with seeds and intervals, and set them beside the published values. Every run is kept\n"
        "when it has ended; the same command goes on where it was interrupted.",
        _reproduce,
        ("hotlap reproduce experts", "hotlap reproduce all --quick --out runs/quick"),
    ),
    "bench": Command("measure the flight core", "Measure how fast the flight core flies on this machine.", _bench, ()),
}


def overview() -> str:
    """The help of `hotlap` itself."""
    width = max(map(len, COMMANDS))
    commands = "\n".join(f"  {name:<{width}}  {command.purpose}" for name, command in COMMANDS.items())
    return f"""usage: hotlap COMMAND [ARGUMENTS]

From a list of gates to a tuned controller: plans the fastest flight through a race track, then tunes a
quadrotor's model-predictive controller in simulated flights until it passes every gate.

commands:
{commands}

options:
  -h, --help  show this help, or that of a command: hotlap tune --help
  --version   show the version

Every command takes --json. Exit status: 0 success, 1 the work failed (goal not reached, no plan), 2 bad input.
To begin with: hotlap tune circle-34
"""
