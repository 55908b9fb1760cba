"""Accessible: what the theme leaves out for people who do not use a mouse, or do not see the page."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx

LATE = 900  # after the theme has drawn its parts
PROGRAM = '<div class="highlight"><pre'
MENDED = {
    "furo_navigation_tree": ((' role="heading"', ' role="heading" aria-level="2"'),),
    "body": (('<div class="table-wrapper', '<div tabindex="0" class="table-wrapper'), (f"{PROGRAM}>", f'{PROGRAM} tabindex="0">')),
}


def mend(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Headings have a level; what scrolls can be reached by keyboard."""
    del app, page, template, doctree
    for part, changes in MENDED.items():
        for before, after in changes:
            if isinstance(context.get(part), str):
                context[part] = context[part].replace(before, after)


def setup(app: Sphinx) -> dict[str, Any]:
    """For Sphinx."""
    app.connect("html-page-context", mend, priority=LATE)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
