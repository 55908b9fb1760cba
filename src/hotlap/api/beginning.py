"""Beginning: where a search begins, and what its first flights said about that."""

from __future__ import annotations

from hotlap.api.asked import Asked
from hotlap.api.scenarios import read_guess
from hotlap.core.ledger import Ledger
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream
from hotlap.first_guess.guess import rival_of
from hotlap.first_guess.names import DEFAULT, LEARNED
from hotlap.reference.scenario import Scenario
from hotlap.study.configuration import Configuration
from hotlap.tuners.contest import FLIGHTS


def begin(asked: Asked, scenario: Scenario) -> tuple[str, Parameters, Parameters | None]:
    """Name and values of the first guess, shape (S, K), and a rival where nothing was asked for and the learnt one has to prove itself.

    Raises:
        InputError: what was asked for cannot be read, or does not fit the scenario.
    """
    if asked.first_guess is not None:
        return str(asked.first_guess), read_guess(str(asked.first_guess), scenario, asked.progress), None
    learnt = read_guess(LEARNED, scenario, asked.progress)
    return LEARNED, learnt, rival_of(scenario, learnt)


def begun_with(configuration: Configuration, ledger: Ledger) -> str:
    """Name of the guess that the search began with; of two that were flown against each other, the better one.

    Args:
        configuration: of the study.
        ledger: its flights.
    """
    if configuration.rival is None:
        return configuration.first_guess_name
    first, rival = _contest(ledger)
    means = [(float(side.completion.mean()), -float(side.cost.mean())) for side in (first, rival) if len(side)]
    return DEFAULT if len(means) == len((first, rival)) and means[1] > means[0] else configuration.first_guess_name


def describe_beginning(configuration: Configuration, ledger: Ledger) -> str:
    """The contest of two guesses in one line; "" where there was none.

    Args:
        configuration: of the study.
        ledger: its flights.
    """
    if configuration.rival is None:
        return ""
    names = ("the learned guess", "the default weights")
    told = [f"{name} {int((side.completion == 1).sum())} of {len(side)}" for name, side in zip(names, _contest(ledger), strict=True)]
    return f"first flights that pass all gates: {', '.join(told)}"


def _contest(ledger: Ledger) -> tuple[Ledger, Ledger]:
    """The first flights of a search: those of the first guess and those of its rival, which are flown in turn."""
    search = ledger.of(Stream.SEARCH)
    return search.rows(slice(0, 2 * FLIGHTS, 2)), search.rows(slice(1, 2 * FLIGHTS, 2))
