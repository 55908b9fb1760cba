"""What may be asked on the command line: every command with its arguments; imports nothing that takes time."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from keyword import iskeyword
from pathlib import Path

from hotlap.api.checking import check
from hotlap.api.comparing import compare
from hotlap.api.exporting import export
from hotlap.api.flying import fly
from hotlap.api.identifying import KNOWN, identify
from hotlap.api.importing import import_file
from hotlap.api.lapping import lap
from hotlap.api.planning import plan
from hotlap.api.scoring import score
from hotlap.api.transferring import transfer
from hotlap.api.tuning import tune
from hotlap.cli.options import GUESSES, PARAMETERS, SHOWN, Shown, add_call
from hotlap.cli.parser import Parser, one_of, path, whole, wrapped
from hotlap.core.vehicle_names import LANGUAGES
from hotlap.files.kinds import Kind
from hotlap.files.suites import SUITES
from hotlap.first_guess.names import DEFAULT
from hotlap.report.formats import FORMATS as PICTURES
from hotlap.reproduce.experiments import EXPERIMENTS
from hotlap.tuning.goal_forms import FORMS, LAP_TIME

SHELLS = ("bash", "zsh", "fish")
REPRODUCED = Path("runs/reproduced")
VEHICLES = ", ".join(f"{language}:{form}" for language, form in LANGUAGES.items())
FIRST_GUESS = Shown("NAME", "first guess", GUESSES)

ABOUT = """From a list of gates to a tuned controller: plans the fastest flight through a race track, then tunes a quadrotor's
model-predictive controller in simulated flights until it passes every gate."""
OPTIONS = {"-h, --help": "show this help, or that of a command: hotlap tune --help", "--version": "show the version"}
EVERY_COMMAND = """Every command takes --json, --verbose and --log-file FILE. Exit status: 0 success, 1 the work failed (goal not
reached, no plan), 2 bad input."""


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
        parser.add_argument("--verbose", action="store_true", help="say what is done, with times; of an error, where it arose")
        parser.add_argument("--log-file", type=path, metavar="FILE", help="append everything that is said to this file, with times")
        return parser


def _race(parser: Parser) -> None:
    parser.add_argument("race", metavar="RACE", help="a built-in race (hotlap races) or a TOML file")


def _study(parser: Parser) -> None:
    parser.add_argument("study", type=path, metavar="DIR", help="folder of a study, as hotlap tune makes it")


def _controller(parser: Parser) -> None:
    shown = SHOWN["controller"]
    kinds = one_of(shown.kind, shown.names)
    names = ", ".join(shown.names)
    parser.add_argument("--controller", type=kinds, metavar="KIND", automatic="the race's", help=f"which one flies: {names}")


def _jobs(parser: Parser) -> None:
    parser.add_argument("--jobs", type=whole, default=0, metavar="N", automatic="one a processor", help="processes")


def _cluster(parser: Parser, does: str) -> None:
    told = f"address of a dask scheduler, or the file it wrote, whose workers {does}"
    parser.add_argument("--cluster", metavar="ADDRESS", automatic="this machine", help=told)


def _listed(*suites: str) -> Callable[[Parser], None]:
    """The argument of a list: what to leave of it."""

    def add(parser: Parser) -> None:
        kinds = "names or patterns, like 'circle*'" if not suites else f"names, patterns like 'circle-*', or sets: {', '.join(suites)}"
        parser.add_argument("names", nargs="*", metavar="NAME", automatic="all", help=f"what to list: {kinds}")

    return add


def _check(parser: Parser) -> None:
    add_call(parser, check, file=Shown("FILE"))


def _new(parser: Parser) -> None:
    add = parser.add_argument
    add("kind", metavar="KIND", type=one_of("kind of file", tuple(Kind)), help=", ".join(Kind))
    add("name", metavar="NAME", help="what it is called; the file is NAME.toml")
    add("--track", metavar="TRACK", automatic="circle", help="of a race: a built-in track or a TOML file")
    add("--vehicle", metavar="QUADROTOR", automatic="a hummingbird", help="of a race: a built-in quadrotor or a TOML file")


def _import(parser: Parser) -> None:
    add_call(parser, import_file)


def _identify(parser: Parser) -> None:
    add_call(parser, identify, known=Shown("LIST", values=", ".join(KNOWN)))


def _plan(parser: Parser) -> None:
    add_call(parser, plan)


def _tune(parser: Parser) -> None:
    forms = f"{FORMS}; or {LAP_TIME}: the fastest plan that holds"
    add_call(parser, tune, out=Shown("DIR"), goal=Shown("GOAL", values=forms))


def _fly(parser: Parser) -> None:
    add_call(parser, fly)


def _lap(parser: Parser) -> None:
    ends = Shown("WHAT", "request", ("land", "hold", "disarm"))
    add_call(parser, lap, on=Shown("VEHICLE", values=VEHICLES), origin=Shown("PLACE"), geofence=Shown("BOX"), on_stop=ends)


def _transfer(parser: Parser) -> None:
    add_call(parser, transfer)


def _score(parser: Parser) -> None:
    add_call(parser, score, log=Shown("LOG"), out=Shown("FILE"))


def _report(parser: Parser) -> None:
    add = parser.add_argument
    _study(parser)
    add("--figures", action="store_true", help="draw every figure of the page as well, each into a file of its own")
    formats, names = one_of("format", PICTURES), ", ".join(PICTURES)
    add("--format", type=formats, default=PICTURES[0], metavar="NAME", help=f"of the figures: {names}")
    add("--video", type=path, metavar="FILE", help="the flight as a moving picture: .gif or .mp4")


def _watch(parser: Parser) -> None:
    add = parser.add_argument
    add("study", type=path, metavar="DIR", help="folder of a study, as hotlap tune makes it, or one with studies in it or below it")
    add("--port", type=whole, default=0, metavar="N", automatic="any that is free", help="to listen on")
    add("--host", default="127.0.0.1", metavar="NAME", help="to listen on; 127.0.0.1 is this machine alone")


def _compare(parser: Parser) -> None:
    add_call(parser, compare, out=Shown("DIR"), first_guess=FIRST_GUESS)
    sets = one_of("set of races", tuple(SUITES))
    parser.add_argument("--races", dest="suite", type=sets, metavar="SET", stands_for="races", help=f"a set of races: {', '.join(SUITES)}")


def _landscape(parser: Parser) -> None:
    _race(parser)
    add = parser.add_argument
    add("--x", default="Q_pos_xy", metavar="NAME", help="parameter along the map")
    add("--y", default="horizon", metavar="NAME", help="parameter across it")
    add("--points", type=whole, default=50, metavar="N", help="along each, evenly in logarithms")
    add("--flights", type=whole, default=4, metavar="N", help="at each point, with the same noise at all")
    add("--first-guess", default=DEFAULT, metavar="NAME", help=f"what the other parameters are: {PARAMETERS}")
    add("--reference", type=path, metavar="FILE", help="read this CSV instead of planning")
    _controller(parser)
    add("--out", type=path, metavar="FILE", help="draw it: .png, .svg or .pdf")
    _cluster(parser, "fly the rows")


def _learn(parser: Parser) -> None:
    add = parser.add_argument
    shipped = "135 that come with hotlap"
    add("races", nargs="*", metavar="RACE", automatic=shipped, help="races to learn from, of one controller")
    add("--out", type=path, required=True, metavar="DIR", help="folder of what is learnt, begun or gone on with")
    _jobs(parser)
    _cluster(parser, "tune and fly the races")


def _reproduce(parser: Parser) -> None:
    add = parser.add_argument
    names = one_of("experiment", (*EXPERIMENTS, "all"))
    add("experiment", metavar="NAME", type=names, help=f"{', '.join(EXPERIMENTS)} or all")
    add("--quick", action="store_true", help="the short form, under a minute each: other races, fewer seeds")
    add("--out", type=path, default=REPRODUCED, metavar="DIR", help="folder of the pages, begun or gone on with")
    _jobs(parser)
    _cluster(parser, "do the runs and flights")


def _export(parser: Parser) -> None:
    add_call(parser, export)


def _bench(parser: Parser) -> None:  # noqa: ARG001  it takes none
    return


def _cache(parser: Parser) -> None:
    parser.add_argument("--clear", action="store_true", help="remove it")


def _completion(parser: Parser) -> None:
    parser.add_argument("shell", metavar="SHELL", type=one_of("shell", SHELLS), help=", ".join(SHELLS))


COMMANDS: Mapping[str, Command] = {
    "races": Command(
        "list the built-in races",
        "List the built-in races and what to expect of them.",
        _listed(*SUITES),
        ("hotlap races", "hotlap races 'circle-*' real"),
    ),
    "tracks": Command("list the built-in tracks", "List the built-in tracks.", _listed(), ("hotlap tracks", "hotlap tracks '*-gates'")),
    "quadrotors": Command(
        "list the built-in quadrotors", "List the built-in quadrotors.", _listed(), ("hotlap quadrotors", "hotlap quadrotors 'airsim*'")
    ),
    "tuners": Command(
        "list the tuners", "List the algorithms that tune, with their presets.", _listed(), ("hotlap tuners", "hotlap tuners 'cma_es:*'")
    ),
    "worlds": Command("list the worlds", "List where flights can happen, and what each still needs.", _listed(), ("hotlap worlds",)),
    "check": Command(
        "say what a file means",
        "Say what a track, quadrotor or race means: thrust margins, latency, lag, limits that bind. A race is planned, and flown with\n"
        "weights that nobody has tuned: how many flights are complete, how the others end, and what would help.",
        _check,
        ("hotlap check my-race.toml", "hotlap check circle-34", "hotlap check my-race.toml --reference mine.csv"),
    ),
    "new": Command(
        "write a file to start from",
        "Write a commented file to start from, every key with its unit and default.",
        _new,
        ("hotlap new quadrotor my-drone", "hotlap new race my-race --vehicle my-drone.toml --track circle"),
    ),
    "import": Command(
        "read a file of another program",
        "Write a track or quadrotor from a file of another program as TOML, and say what was assumed and what is not carried over.\n"
        "Reads files of TOGT-Planner, lsy_drone_racing, rpg_time_optimal, agilicious, Fast-fly, the MRS simulator and drone-models,\n"
        "Gazebo's SDF, and the URDF of gym-pybullet-drones; airsim:// asks a simulator that runs for the gates of its level.",
        _import,
        (
            "hotlap import race_uzh_7g_multiprisma.yaml",
            "hotlap import params.toml --name cf21B_500 --out my-drone.toml",
            "hotlap import airsim://127.0.0.1:41451 --out my-track.toml",
        ),
    ),
    "identify": Command(
        "find a drone's numbers in logs of its flights",
        "Find a quadrotor's thrust, motor lag, rate loop, dead time and drag in logs of its flights, each with a 95 % interval; say how\n"
        "well they predict what was not fitted, what the logs cannot tell, and which manoeuvre would. Writes a quadrotor on its base.",
        _identify,
        (
            "hotlap identify flight.csv --quadrotor five-inch --out my-drone.toml",
            "hotlap identify first.csv second.csv --quadrotor my-base.toml --picture predicted.png",
        ),
    ),
    "plan": Command(
        "plan the fastest reference",
        "Plan the minimum-time reference of a race, segment it, and write it for others to read.",
        _plan,
        ("hotlap plan circle-34 --out circle.csv --picture circle.png",),
    ),
    "tune": Command(
        "tune the controller for a race",
        "Tune the controller until the goal holds in fresh flights, validate it, and write a page. Every flight is recorded; the same\n"
        "command with --out goes on where it was interrupted. Exits with 1 when the goal was not confirmed within the budget.",
        _tune,
        (
            "hotlap tune circle-34",
            "hotlap tune my-race.toml --budget 500 --out runs/mine",
            'hotlap tune my-race.toml --hold "mass=+-10%, wind=2"',
            'hotlap tune split-s --goal "mean_error<0.3"',
        ),
    ),
    "compare": Command(
        "compare tuners on equal terms",
        "Run tuners on races with the same first guess, budget, seeds and noise, and say how they did: tables, curves, a profile.\n"
        "Every run is kept when it has ended; the same command goes on where it was interrupted.",
        _compare,
        (
            "hotlap compare drop-20 flip-16 --out runs/compared",
            "hotlap compare 'circle-*' --out runs/circles",
            "hotlap compare --races airsim --seeds 3 --out runs/airsim",
            "hotlap compare my-race.toml --tuners gate_gp,cma_es:tied --seeds 20 --out runs/mine",
            "hotlap compare --races all --out runs/all --cluster tcp://head:8786",
        ),
    ),
    "fly": Command(
        "fly parameters again",
        "Fly a race with given parameters and fresh noise, and say how the flights ended.",
        _fly,
        ("hotlap fly circle-34", "hotlap fly circle-34 --parameters runs/mine --flights 1000"),
    ),
    "lap": Command(
        "fly a real vehicle once",
        "Fly a real vehicle around a race once: it takes off, hovers at the start, flies the tuned controller, brakes and lands.\n"
        "Nothing is armed without --arm; a lost link, an old state, the geofence or Ctrl-C stop it. Read docs/real_flight.md first.",
        _lap,
        (
            "hotlap lap my-race.toml --parameters runs/mine --on mavlink:udpin:127.0.0.1:14540 --dry-run",
            "hotlap lap my-race.toml --parameters runs/mine --on mavlink:udpin:127.0.0.1:14540 --arm",
            "hotlap lap my-race.toml --parameters runs/mine --on mavlink:serial:/dev/ttyACM0:921600 --origin here --arm",
            "hotlap lap my-race.toml --parameters runs/mine --on crazyflie:radio://0/80/2M/E7E7E7E7E7 --arm",
        ),
    ),
    "transfer": Command(
        "fly parameters in other worlds",
        "Fly the parameters of a study, and the default ones, in other worlds than the one they were tuned in, with the same noise; write\n"
        "a page with the tracking errors. Every flight is kept when it has ended; the same command goes on where it was interrupted.",
        _transfer,
        ("hotlap transfer runs/mine --to betaflight", "hotlap transfer runs/mine --to rotorpy,crazyflow --flights 10"),
    ),
    "score": Command(
        "judge a flight that really happened",
        "Read the log of a flight, judge it by the judge of a race, and set it beside simulated flights: gates passed, lap time, error,\n"
        "command effort. Reads logs of PX4, Betaflight, ArduPilot, ROS and tables; pip install 'hotlap[logs]'.",
        _score,
        ("hotlap score flight.ulg --race circle-34 --align", "hotlap score flight.csv --race my-race.toml --out flight.html"),
    ),
    "report": Command(
        "write the page of a study again",
        "Write report.html into the folder of a study: the flight in three dimensions, what was tuned, and whether it will hold, in one\n"
        "file that needs no network. Its flights are flown again with fresh noise.",
        _report,
        ("hotlap report runs/mine", "hotlap report runs/mine --figures --format pdf", "hotlap report runs/mine --video lap.gif"),
    ),
    "watch": Command(
        "show a study, or a folder of them, in the browser",
        "Show the page of a study to browsers on this machine, and keep it up to date as flights come in, until Ctrl-C. Of a folder of\n"
        "studies it shows a table of all, to be sorted and sifted, and the page of each. Nothing is written; --json prints the address\n"
        "at once.",
        _watch,
        ("hotlap watch runs/mine", "hotlap watch runs", "hotlap watch runs/mine --port 8080"),
    ),
    "export": Command(
        "write parameters for other programs",
        "Write tuned parameters as other programs read them: mpc.yaml of rpg_mpc, weights for acados, JSON, TOML, CSV; the vehicle for\n"
        "PX4 and agilicious; a flight with them for Foxglove and ROS 2; or all flights of a study for optuna-dashboard.",
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
    "cache": Command(
        "show or remove what is kept between runs",
        "Say where plans and compiled code are kept between runs, and how large they are. All of it can be made again: a plan takes\n"
        "seconds, the code of the flight core about twenty.",
        _cache,
        ("hotlap cache", "hotlap cache --clear"),
    ),
    "completion": Command(
        "complete commands in a shell",
        "Print what makes a shell complete commands, options, races, quadrotors, tracks and tuners when Tab is pressed.",
        _completion,
        ('eval "$(hotlap completion bash)"', 'eval "$(hotlap completion zsh)"', "hotlap completion fish | source"),
    ),
    "bench": Command("measure the flight core", "Measure how fast the flight core flies on this machine.", _bench, ()),
}


def module_of(command: str) -> str:
    """The module of a command: its name, unless Python keeps that for itself."""
    return f"hotlap.cli.{command}{'ing' if iskeyword(command) else ''}"


def overview() -> str:
    """The help of `hotlap` itself, as wide as the terminal."""
    columns = shutil.get_terminal_size().columns - 1
    width = max(map(len, COMMANDS))
    beside = " " * (width + 4)
    parts = [
        "usage: hotlap COMMAND [ARGUMENTS]",
        wrapped(ABOUT, columns),
        "commands:\n" + "\n".join(wrapped(command.purpose, columns, beside, f"  {name:<{width}}  ") for name, command in COMMANDS.items()),
        "options:\n" + "\n".join(wrapped(meaning, columns, " " * 14, f"  {option:<10}  ") for option, meaning in OPTIONS.items()),
        wrapped(EVERY_COMMAND, columns),
        "To begin with: hotlap tune circle-34",
    ]
    return "\n\n".join(parts) + "\n"
