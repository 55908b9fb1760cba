"""An Optuna study in SQLite, for optuna-dashboard: every search flight a trial."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.core.errors import InputError
from hotlap.core.ledger import Ledger
from hotlap.core.seeds import Stream
from hotlap.core.version import __version__
from hotlap.exporters.flown_with import flown_with
from hotlap.study.study import Study
from hotlap.system.whole_files import written_whole

if TYPE_CHECKING:
    from optuna.storages import RDBStorage
    from optuna.trial import FrozenTrial

MISSING = "optuna needs the package optuna: pip install 'hotlap[optuna]'"


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the flights so far; the study need not have ended.

    Raises:
        InputError: optuna is not installed, or the file cannot be written.
    """
    try:
        import optuna  # noqa: PLC0415  an extra, and slow to load
    except ImportError:
        raise InputError("", "format", MISSING) from None
    try:
        with written_whole(path) as part, _storage(part) as storage:
            made = optuna.create_study(storage=storage, study_name=_name(study), direction="minimize")
            for key, value in _remarks(study).items():
                made.set_user_attr(key, value)
            made.add_trials(trials(study))
    except optuna.exceptions.StorageInternalError as error:
        raise InputError(str(path), "", f"cannot be written: {error}") from None
    return (path,)


def trials(study: Study) -> list[FrozenTrial]:
    """A trial for each search flight, in the order flown; a flight without a finite cost is a trial that failed."""
    from optuna.distributions import FloatDistribution  # noqa: PLC0415
    from optuna.trial import TrialState, create_trial  # noqa: PLC0415

    space, ledger = study.configuration.scenario.space, study.flights()
    flown, again = ledger.of(Stream.SEARCH), _reflights(ledger)
    segments = len(study.configuration.scenario.segments)
    axes = [
        (parameter_name(name, segment), FloatDistribution(float(low), float(high), log=True))
        for segment in range(segments)
        for name, low, high in zip(space.names, space.low, space.high, strict=True)
    ]
    rows = zip(flown.parameters.reshape(len(flown), -1).tolist(), flown.cost.tolist(), strict=True)
    return [
        create_trial(
            state=TrialState.COMPLETE if math.isfinite(cost) else TrialState.FAIL,
            value=cost if math.isfinite(cost) else None,
            params={name: value for (name, _), value in zip(axes, values, strict=True)},
            distributions=dict(axes),
            user_attrs=_attributes(flown, i) | again.get(flown.parameters[i].tobytes(), {}),
        )
        for i, (values, cost) in enumerate(rows)
    ]


def parameter_name(name: str, segment: int) -> str:
    """What a parameter of a segment is called."""
    return f"{name} [{segment}]"


def _attributes(flown: Ledger, i: int) -> dict[str, Any]:
    """What a flight did; what is not finite is left out."""
    values = {name: getattr(flown, name)[i].item() for name in ("completion", "lap_time", "accepted", "failed_segment", "mean_error")}
    more = {"max_error": flown.max_error[i].item(), "seed": flown.seeds[i].item(), "number": flown.numbers[i].item()}
    return {key: value for key, value in {**values, **more}.items() if math.isfinite(value)}


def _reflights(ledger: Ledger) -> dict[bytes, dict[str, Any]]:
    """How the re-flights, the selection and the validation of the same parameters went, by their bytes."""
    found: dict[bytes, dict[str, Any]] = {}
    names = {Stream.CONFIRMATION: "reflights", Stream.SELECTION: "selection_flights", Stream.VALIDATION: "validation_flights"}
    for stream, name in names.items():
        flights = ledger.of(stream)
        for parameters, completion in zip(flights.parameters, flights.completion.tolist(), strict=True):
            entry = found.setdefault(parameters.tobytes(), {})
            entry[name] = entry.get(name, 0) + 1
            entry[f"{name}_complete"] = entry.get(f"{name}_complete", 0) + int(completion >= 1)
    return found


def _remarks(study: Study) -> dict[str, Any]:
    """What the study is of, and how it stands."""
    configuration, result = study.configuration, study.result
    known = {
        "hotlap": __version__,
        "race": configuration.scenario.race.name,
        "world": configuration.world,
        "metric": str(configuration.metric),
        "tuner": configuration.tuner,
        "flown_with": flown_with(configuration.scenario),
        "segments": [str(kind) for kind in configuration.scenario.segments.segment_classes],
    }
    return known if result is None else known | {key: value for key, value in result.dump().items() if value is not None}


def _name(study: Study) -> str:
    configuration = study.configuration
    return f"{configuration.scenario.race.name} {configuration.tuner} seed {configuration.settings.seed}"


@contextmanager
def _storage(path: Path) -> Iterator[RDBStorage]:
    """Optuna's tables in a new file, with its messages silenced; closed when done."""
    from optuna import logging  # noqa: PLC0415
    from optuna.storages import RDBStorage  # noqa: PLC0415

    before = logging.get_verbosity()
    logging.set_verbosity(logging.ERROR)
    storage = RDBStorage(f"sqlite:///{path.absolute()}")
    try:
        yield storage
    finally:
        storage.remove_session()
        storage.engine.dispose()
        logging.set_verbosity(before)
