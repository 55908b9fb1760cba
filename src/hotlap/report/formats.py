"""Kinds of picture files; imports nothing that takes time."""

FORMATS = ("png", "svg", "pdf")
SUFFIXES = tuple(f".{name}" for name in FORMATS)
