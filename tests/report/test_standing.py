"""How a study stands is read at one moment, also while another process adds flights."""

from __future__ import annotations

import threading

from plausible_world import PlausibleWorld
from studies import configure

from hotlap.objective import Objective
from hotlap.report.page.standing import read_standing
from hotlap.study import Study, carry_out
from hotlap.tuning import tune


def test_flights_that_come_in_meanwhile_are_of_the_next_reading(tmp_path, monkeypatch):
    asked, folder, read = configure(goal="none", batch=2), tmp_path / "study", Study.flights
    with Study.open(folder, asked) as study:
        study.record(next(iter(tune(Objective(asked.course, PlausibleWorld()), study.tuning))))

    def go_on():
        with Study.open(folder, asked) as study:
            carry_out(study, Objective(asked.course, PlausibleWorld()))

    writer = threading.Thread(target=go_on)

    def flights(study):
        """Just before the flights are read, another one tries to add all that are left."""
        if not writer.ident:
            writer.start()
            writer.join(timeout=2)  # it may have to wait until this has been read
        return read(study)

    monkeypatch.setattr(Study, "flights", flights)
    with Study.read(folder) as study:
        before = read_standing(study)
        writer.join()
        after = read_standing(study)
    for standing in (before, after):
        assert standing.result is not None
        assert len(standing.ledger) == standing.result.flights + standing.result.validation_flights
    assert (before.finished, after.finished) == (False, True)
    assert len(before.ledger) < len(after.ledger)
