"""Main: finds the command, runs it, and turns every way to end into an exit status and at most one line."""

from __future__ import annotations

import gc
import io
import shlex
import sys
import warnings
from collections.abc import Callable, Sequence
from importlib import import_module

from hotlap.cli.arguments import COMMANDS, module_of, overview
from hotlap.cli.failures import complain, drop_output, print_json, wants_json
from hotlap.cli.log import LOG, logged
from hotlap.cli.parser import HELP
from hotlap.cli.stopping import Stopped, stopped_by_signals
from hotlap.core.errors import HotlapError, InputError, StorageError, UnknownNameError
from hotlap.core.own_code import OwnCode
from hotlap.core.platforms import unsupported
from hotlap.core.version import __version__
from hotlap.system.blas_threads import one_thread

SUCCESS, FAILURE, BAD_INPUT = 0, 1, 2
ALLOCATIONS = 100_000  # between looks for garbage: while libraries are loaded there is none, and looking takes a tenth of a second
PIPE_CLOSED = 141  # 128 + SIGPIPE, as of any program whose reader went away


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: without the program's name; None: those of the process.

    Returns:
        Exit status: 0 success, 1 the work failed, 2 bad input, 128 + the signal that stopped it.
    """
    if unsupported():
        return complain(unsupported(), FAILURE)
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    gc.set_threshold(ALLOCATIONS)
    one_thread()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal without our characters is no reason to fail
    try:
        with stopped_by_signals(), warnings.catch_warnings():
            warnings.showwarning = _show_each_once()
            status = _run(arguments)
            sys.stdout.flush()
            return status
    except HotlapError as error:
        status = FAILURE if isinstance(error, StorageError) or not isinstance(error, InputError) else BAD_INPUT
        if wants_json(arguments):
            print_json(error, status)
        return complain(str(error), status)
    except KeyboardInterrupt as stop:
        notes = getattr(stop, "__notes__", [f"begin again with: {shlex.join(['hotlap', *arguments])}"])
        return complain(f"interrupted; {notes[0]}", stop.code if isinstance(stop, Stopped) else 130)
    except BrokenPipeError:
        drop_output()
        return PIPE_CLOSED
    except OSError as error:
        if error.filename is None:
            drop_output()
        elif wants_json(arguments):
            print_json(error, FAILURE)
        return complain(f"{error.filename or 'standard output'}: {error.strerror or error}", FAILURE)


def _run(arguments: list[str]) -> int:
    """Find the command and call it."""
    if not arguments or arguments[0] in HELP:
        sys.stdout.write(overview())
        return SUCCESS
    name, *rest = arguments
    if name == "--version":
        sys.stdout.write(f"hotlap {__version__}\n")
        return SUCCESS
    if name.startswith("-"):
        raise InputError(name, "", "is no option of hotlap; options of a command follow its name, see hotlap --help")
    if name not in COMMANDS:
        raise UnknownNameError("command", name, COMMANDS)
    parser = COMMANDS[name].parser(name)
    options = parser.parse(rest)
    if options is None:
        sys.stdout.write(parser.format_help())
        return SUCCESS
    options.arguments = tuple(rest)
    with logged(options, name, rest):
        try:
            return import_module(module_of(name)).run(options)
        except InputError as error:
            if parser.as_option(error) is error:
                raise
            raise parser.as_option(error) from error


def _show_each_once() -> Callable[..., None]:
    """Shows a warning as one line, without the place in the code that it came from; the same words are shown once."""
    said: set[str] = set()

    def show(message: Warning | str, *_: object) -> None:
        if str(message) not in said:
            LOG.warning("%s", message)
            said.add(str(message))
            sys.stderr.write(f"hotlap: {'' if isinstance(message, OwnCode) else 'warning: '}{message}\n")

    return show
