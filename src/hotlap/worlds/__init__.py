"""Worlds: where flights happen; all answer to the protocol of `world.py`."""
