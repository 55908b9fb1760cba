"""Analysis: experiments on tunings and controllers, as functions; no files."""
