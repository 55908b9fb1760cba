"""HotlapSampler: any of hotlap's tuners as a sampler of Optuna."""

from __future__ import annotations

import math
import random
import threading
import time
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from optuna.distributions import BaseDistribution
from optuna.samplers import BaseSampler, RandomSampler
from optuna.search_space import intersection_search_space
from optuna.study import Study, StudyDirection
from optuna.trial import FrozenTrial, TrialState

from hotlap import tuners
from hotlap.core.records import Scores
from hotlap.optuna.box import Box
from hotlap.optuna.run import KEY, Note, Origin, TunerRun, cost_of

DEFAULT = "guided_walk"  # a function has no gates
PRESETS = {"random_search": "log_uniform"}  # where the default of a tuner has steps in the units of a controller's weights
SEED = "hotlap:seed"  # attribute of a study that holds its seed
POINT = "hotlap:point"  # attribute of a trial that holds the point that it tries
BLOCK = 20  # trials elsewhere of which one lies in each twentieth of every range
TRIES, WAIT = 50, 0.01  # attempts to reserve a point that no other process tries, and longest wait [s] after the first


class HotlapSampler(BaseSampler):
    """A sampler for numbers, `suggest_float` and `suggest_int`, on a grid or in logarithms; for one objective.

    The first trials are drawn at random; the tuner then begins at the best of them (give your own with `study.enqueue_trial`). Parameters
    that are not numbers, or not in every trial, are always drawn at random. A trial that fails or is pruned counts as worse than any
    other. Every tenth trial looks elsewhere, whatever the tuner: twenty of them lie in all twentieths of every range. Where one of them is
    clearly better than all that the tuner has tried, the tuner begins anew there.

    The whole state is in the study's storage: another process continues as this one would have, and several may work at once.
    With trials in parallel, guided_walk and gate_gp learn from all of them, and assume the median cost for those that have not ended. The
    other tuners depend on the order of the reported scores: trials that run at the same time belong to one ask of up to `batch` points;
    when all of these are being tried, further trials belong to another run of the tuner, which begins at the best trial of that time.

    Args:
        tuner: NAME or NAME:PRESET, as of `hotlap tune --tuner`; random_search alone is random_search:log_uniform, uniform over the ranges.
        seed: seed of all random numbers; None: that of the study, or a new one that is kept in the study.
        startup: complete trials before the tuner begins, at least 1.
        batch: largest number of points that a tuner is asked for at once; guided_walk and gate_gp give one.
        elsewhere: every so-manieth trial is drawn anywhere within the ranges; 0: none is.
        independent_sampler: sampler of the other parameters; None: at random.

    Raises:
        UnknownNameError: there is no such tuner.
        InputError: a tuner of your own that breaks the protocol; a number that has no meaning.
    """

    def __init__(
        self,
        tuner: str = DEFAULT,
        *,
        seed: int | None = None,
        startup: int = 5,
        batch: int = 8,
        elsewhere: int = 10,
        independent_sampler: BaseSampler | None = None,
    ) -> None:
        if startup < 1 or batch < 1:
            raise ValueError(f"startup and batch must be at least 1, not {startup} and {batch}")
        if elsewhere < 0 or elsewhere == 1:
            raise ValueError(f"elsewhere must be 0, or 2 and more, not {elsewhere}")
        built = tuners.build(f"{tuner}:{PRESETS[tuner]}" if tuner in PRESETS else tuner)
        self._tuner, self._learns_from_any = built.name, bool(getattr(built, "learns_from_any", False))
        self._seed, self._startup, self._batch, self._independent = seed, startup, batch, independent_sampler
        self._elsewhere = elsewhere
        self._runs: dict[tuple[int, Origin], TunerRun] = {}
        self._lock = threading.Lock()

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_runs": {}, "_lock": None}  # runs are rebuilt from the study

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._lock = threading.Lock()

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """The numeric parameters of all complete trials; empty before there are `startup` of them.

        Raises:
            ValueError: the study has several objectives.
        """
        if len(study.directions) != 1:
            raise ValueError(f"HotlapSampler is for one objective; the study has {len(study.directions)}")
        complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        if len(complete) < self._startup or "fixed_params" in trial.system_attrs:
            return {}
        return {axis.name: axis.distribution for axis in Box.of(intersection_search_space(complete)).axes}

    def sample_relative(self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]) -> dict[str, Any]:
        """The parameters that the tuner asks for next."""
        box = Box.of(search_space)
        if not box.axes:
            return {}
        with self._lock:
            trials, sign = study.get_trials(deepcopy=False), _sign(study)
            costs = {each.number: cost_of(each, sign) for each in trials if each.number != trial.number and box.holds(each.params)}
            finite = [cost for cost in costs.values() if math.isfinite(cost)]
            if not finite:
                return {}
            costs = {number: min(finite) if cost == -math.inf else cost for number, cost in costs.items()}
            if self._elsewhere and (trial.number + 1) % self._elsewhere == 0:
                return box.of_shares(anywhere((trial.number + 1) // self._elsewhere - 1, len(box.axes), self._seed_of(study)))
            return self._from_all(study, trial, box, costs) if self._learns_from_any else self._from_runs(study, trial, box, costs)

    def sample_independent(self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution) -> Any:
        """A random value that depends only on the seed, the trial and the parameter."""
        sampler = self._independent or RandomSampler(_small([self._seed_of(study), trial.number, zlib.crc32(param_name.encode())]))
        return sampler.sample_independent(study, trial, param_name, param_distribution)

    def reseed_rng(self) -> None:
        """Pass on to the independent sampler; the own random numbers of two trials are never the same."""
        if self._independent is not None:
            self._independent.reseed_rng()

    def before_trial(self, study: Study, trial: FrozenTrial) -> None:
        """Pass on to the independent sampler."""
        if self._independent is not None:
            self._independent.before_trial(study, trial)

    def after_trial(self, study: Study, trial: FrozenTrial, state: TrialState, values: Sequence[float] | None) -> None:
        """Pass on to the independent sampler."""
        if self._independent is not None:
            self._independent.after_trial(study, trial, state, values)

    def _from_all(self, study: Study, trial: FrozenTrial, box: Box, costs: dict[int, float]) -> dict[str, Any]:
        """Report all trials to a new tuner, and take its first proposal."""
        trials = study.get_trials(deepcopy=False)
        points = [box.encode(trials[number].params) for number, cost in costs.items() if not np.isnan(cost)]
        known = _normalised(np.array([cost for cost in costs.values() if not np.isnan(cost)]))
        under_way = [point for each in trials if each.number != trial.number and (point := _tries(each, box)) is not None]
        assumed = np.full(len(under_way), np.median(known[np.isfinite(known)]))
        tuner = tuners.build(self._tuner)
        tuner.start(points[int(np.argmin(known))], box.space, np.random.default_rng([self._seed_of(study), trial.number]))
        tuner.tell(np.array(points + under_way), Scores.of_costs(np.append(known, assumed)))
        proposal = tuner.ask(1)[0]
        study._storage.set_trial_system_attr(trial._trial_id, POINT, [box.fingerprint, proposal.tolist()])  # noqa: SLF001  as all samplers do
        return box.decode(proposal)

    def _from_runs(self, study: Study, trial: FrozenTrial, box: Box, costs: dict[int, float]) -> dict[str, Any]:
        """The next point of a run that has one left, or of a new run; noted in the trial.

        A storage cannot reserve a point. So the point is noted first; a process that then finds it in another trial too waits and
        chooses another point.
        """
        for attempt in range(TRIES):
            note, point = self._next(study, trial, box, costs)
            study._storage.set_trial_system_attr(trial._trial_id, KEY, note.dump())  # noqa: SLF001  as all samplers do
            others = (Note.of(each) for each in study.get_trials(deepcopy=False) if each.number != trial.number)
            if all(other is None or other.point != note.point for other in others):
                return box.decode(point)
            time.sleep(random.random() * WAIT * (attempt + 1))
        study._storage.set_trial_system_attr(trial._trial_id, KEY, None)  # noqa: SLF001
        return {}

    def _next(self, study: Study, trial: FrozenTrial, box: Box, costs: dict[int, float]) -> tuple[Note, Any]:
        """The first point that is in no other trial's note."""
        trials, sign = study.get_trials(deepcopy=False), _sign(study)
        tried: dict[Origin, dict[tuple[int, int], tuple[FrozenTrial, float]]] = {}
        last = -1
        for each in trials:
            note = Note.of(each)
            if note is None or each.number == trial.number:
                continue
            last = max(last, note.origin.run)
            if (note.origin.tuner, note.origin.space) == (self._tuner, box.fingerprint):
                tried.setdefault(note.origin, {}).setdefault((note.ask, note.place), (each, cost_of(each, sign)))
        best_elsewhere = min(self._found_elsewhere(trials, costs), default=math.inf)
        for origin, mine in tried.items():
            if best_elsewhere < min([origin.best, *(cost for _, cost in mine.values())]) - origin.spread:
                continue
            found = self._run(study, origin, box, trials).next(mine)
            if found is not None:
                return found
        found = self._run(study, self._begin(study, last + 1, box, costs), box, trials).next({})
        assert found is not None, "a new run has something to try"  # noqa: S101  our own mistake
        return found

    def _found_elsewhere(self, trials: Sequence[FrozenTrial], costs: dict[int, float]) -> list[float]:
        """Costs of the trials that looked elsewhere."""
        if not self._elsewhere:
            return []
        numbers = range(self._elsewhere - 1, len(trials), self._elsewhere)
        return [costs[number] for number in numbers if number in costs and Note.of(trials[number]) is None]

    def _run(self, study: Study, origin: Origin, box: Box, trials: Sequence[FrozenTrial]) -> TunerRun:
        """A run, as far as this process has rebuilt it."""
        key = study._study_id, origin  # noqa: SLF001  names repeat from storage to storage
        if key not in self._runs:
            self._runs[key] = TunerRun(origin, box, trials[origin.trial].params)
        return self._runs[key]

    def _begin(self, study: Study, run: int, box: Box, costs: dict[int, float]) -> Origin:
        """A new run, from the best trial."""
        best = min(costs, key=lambda number: (np.nan_to_num(costs[number], nan=np.inf), number))
        finite = np.array([cost for cost in costs.values() if np.isfinite(cost)])
        spread = float(np.median(finite - finite.min())) or float(np.ptp(finite)) or abs(costs[best]) or 1.0
        return Origin(run, self._tuner, box.fingerprint, self._seed_of(study), self._batch, best, costs[best], spread)

    def _seed_of(self, study: Study) -> int:
        """The seed of a study, given or read from its storage; it is stored there from now on."""
        storage, place = study._storage, study._study_id  # noqa: SLF001  as all samplers do
        kept = storage.get_study_system_attrs(place).get(SEED)
        seed = self._seed if self._seed is not None else kept
        seed = _small(None) if seed is None else seed
        if seed != kept:
            storage.set_study_system_attr(place, SEED, seed)
        return seed


def _sign(study: Study) -> float:
    return -1.0 if study.direction == StudyDirection.MAXIMIZE else 1.0


def anywhere(index: int, size: int, seed: int) -> np.ndarray:
    """A point that depends on the seed alone; of `BLOCK` in a row, from a multiple of it, one lies in each stratum of every axis.

    Args:
        index: from 0.
        size: number of axes.
        seed: of the study.

    Returns:
        Shares of the ranges, shape (size,), 0 to 1.
    """
    block, place = divmod(index, BLOCK)
    rng = np.random.default_rng([seed, block])
    strata = np.array([rng.permutation(BLOCK) for _ in range(size)])
    return ((strata + rng.random((size, BLOCK))) / BLOCK)[:, place]


def _small(entropy: Sequence[int] | None) -> int:
    """A seed that fits into 32 bits."""
    return int(np.random.SeedSequence(entropy).generate_state(1)[0])


def _normalised(costs: np.ndarray) -> np.ndarray:
    """Costs shifted and scaled to a minimum of 0 and a median of 10, since tuners take the logarithm of 1 + cost."""
    finite = costs[np.isfinite(costs)]
    away = costs - finite.min()
    spread = float(np.median(away[np.isfinite(away)])) or float(np.ptp(finite)) or 1.0
    return 10.0 * away / spread


def _tries(trial: FrozenTrial, box: Box) -> np.ndarray | None:
    """The point of this search space that a running trial tries, shape (1, K); None for other trials."""
    space, point = trial.system_attrs.get(POINT, ("", None))
    return np.array(point) if trial.state is TrialState.RUNNING and space == box.fingerprint else None
