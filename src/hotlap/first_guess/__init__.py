"""First guess: initial parameters of a search, learnt from races that were tuned before, as in Sec. IV-D of the paper or by a vote."""

from hotlap.first_guess.guess import NAMES, first_guess
from hotlap.first_guess.training_set import TrainingSet, load_training_set, shipped

__all__ = ["NAMES", "TrainingSet", "first_guess", "load_training_set", "shipped"]
