"""First guess: initial parameters of a search, learnt from races that were tuned before, as in Sec. IV-D of the paper or by a vote."""
