"""How a study stands is read at one moment, also while another process adds flights."""

from __future__ import annotations

import threading

from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study
from hotlap.tuning.loop import tune
from hotlap.tuning.objective import Objective
from plausible_world import PlausibleWorld
from studies import configure


def test_flights_that_come_in_meanwhile_are_of_the_next_reading(tmp_path, monkeypatch):
    asked, folder, read = configure(goal="none", batch=2), tmp_path / "study", Study.flights
    with Study.open(folder, asked) as study:
        study.record(next(iter(tune(Objective(asked.scenario, PlausibleWorld()), study.tuning))))

    def go_on():
        with Study.open(folder, asked) as study:
            study.run(Objective(asked.scenario, PlausibleWorld()))

    writer = threading.Thread(target=go_on)

    def flights(study):
        """Just before the flights are read, another one tries to add all that are left."""
        if not writer.ident:
            writer.start()
            writer.join(timeout=2)  # it may have to wait until this has been read
        return read(study)

    monkeypatch.setattr(Study, "flights", flights)
    with Study.read(folder) as study:
        before = read_snapshot(study)
        writer.join()
        after = read_snapshot(study)
    for snapshot in (before, after):
        assert snapshot.result is not None
        assert len(snapshot.ledger) == snapshot.result.flights + snapshot.result.validation_flights
    assert (before.finished, after.finished) == (False, True)
    assert len(before.ledger) < len(after.ledger)
