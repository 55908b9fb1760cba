"""Scripts of the pages that are no study's: small files of JavaScript, put into the page whole."""

from __future__ import annotations

from importlib.resources import files as package_files


def load_script(*names: str) -> str:
    """The scripts of these names, one behind the other, as the content of one element."""
    return "\n".join((package_files(__name__) / f"{name}.js").read_text(encoding="utf-8").strip() for name in names)
