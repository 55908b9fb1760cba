"""Notebooks: pages of the documentation that are notebooks, shown with the outputs that are kept in them; nothing is run."""

from __future__ import annotations

import json
from typing import Any

from sphinx.application import Sphinx

SUFFIX = ".ipynb"
FIRST = 100  # priority: before whatever else changes pages as they are read


def markdown(notebook: dict[str, Any]) -> str:
    """A notebook as a page: text, code, and what the code gave."""
    return "\n\n".join(_cell(cell) for cell in notebook["cells"])


def _cell(cell: dict[str, Any]) -> str:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return source
    return "\n\n".join([f"```python\n{source}\n```", *map(_output, cell["outputs"])])


def _output(output: dict[str, Any]) -> str:
    """What a cell gave, in the best form that there is of it."""
    if output["output_type"] == "stream":
        return _block("text", "".join(output["text"]))
    data = output["data"]
    if "image/png" in data:
        picture = "".join(data["image/png"]).strip()
        return _block("{raw} html", f'<img class="output" alt="the figure that this cell draws" src="data:image/png;base64,{picture}">')
    if "text/html" in data:
        return _block("{raw} html", f'<div class="output" tabindex="0">{"".join(data["text/html"])}</div>')
    return _block("text", "".join(data["text/plain"]))


def _block(kind: str, text: str) -> str:
    return f"````{kind}\n{text.rstrip()}\n````"


def fill(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the page in the place of the notebook."""
    if str(app.env.doc2path(name)).endswith(SUFFIX):
        source[0] = markdown(json.loads(source[0]))


def setup(app: Sphinx) -> dict[str, bool]:
    """Read notebooks as pages."""
    app.add_source_suffix(SUFFIX, "markdown")
    app.connect("source-read", fill, priority=FIRST)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
