"""Study: a tuning that is recorded on disk, and continues after an interruption."""
