"""Shells: scripts that let a shell complete what may be asked of `hotlap`, made from its parsers.

    words (what may follow what) -> bash | zsh | fish

The scripts hold the names of the version that printed them, so that Tab does not start Python.
"""
