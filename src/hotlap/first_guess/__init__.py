"""First guess: where a search begins, learnt from races that were tuned before (Sec. IV-D of the paper, and a simpler way)."""
