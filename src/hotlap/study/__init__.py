"""Study: a tuning on disk, which goes on after a power cut."""
