"""First guesses by name; imports nothing that takes time."""

LEARNED, PAPER, DEFAULT = "learned", "paper", "default"
NAMES = (LEARNED, PAPER, DEFAULT)
