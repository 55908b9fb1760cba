"""First guess: where a search begins, learnt from races that were tuned before (Sec. IV-D of the paper, and a simpler way)."""

from hotlap.first_guess.guess import NAMES, first_guess
from hotlap.first_guess.training_set import TrainingSet, load_training_set, shipped

__all__ = ["NAMES", "TrainingSet", "first_guess", "load_training_set", "shipped"]
