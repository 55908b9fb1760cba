"""Run the notebook of the documentation and keep what its cells give: `python docs/notebook.py`; Jupyter runs it just as well."""

from __future__ import annotations

import ast
import base64
import io
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure

NOTEBOOK = Path(__file__).with_name("notebook.ipynb")
WIDTH = 140  # characters of a data frame, whatever the terminal
DPI = 70  # of figures: a page is read, not printed

Cell = dict[str, Any]
Output = dict[str, Any]


def read(path: Path = NOTEBOOK) -> dict[str, Any]:
    """A notebook."""
    return json.loads(path.read_text(encoding="utf-8"))


def code_cells(notebook: dict[str, Any]) -> list[Cell]:
    """Its cells of code."""
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def run(notebook: dict[str, Any]) -> Iterator[tuple[Cell, list[Output]]]:
    """Run all cells in an empty folder, one after the other in one namespace.

    Yields:
        Each cell of code, and what it gives.
    """
    space: dict[str, Any] = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory() as folder, chdir(folder), pd.option_context("display.width", WIDTH, "display.max_columns", None):
        for i, cell in enumerate(code_cells(notebook), start=1):
            yield cell, _outputs("".join(cell["source"]), space, i)


def _outputs(source: str, space: dict[str, Any], number: int) -> list[Output]:
    """What a cell prints, and the value of its last line."""
    *statements, last = ast.parse(source).body
    ended = isinstance(last, ast.Expr) and not source.rstrip().endswith(";")
    before = ast.Module(statements if ended else [*statements, last], type_ignores=[])
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile(before, f"<cell {number}>", "exec"), space)  # noqa: S102  our own page
        value = eval(compile(ast.Expression(last.value), f"<cell {number}>", "eval"), space) if ended else None  # noqa: S307
    found = [{"output_type": "stream", "name": "stdout", "text": _lines(printed.getvalue())}] if printed.getvalue() else []
    if value is not None:
        found.append({"output_type": "execute_result", "execution_count": number, "metadata": {}, "data": _data(value)})
    return found


def _data(value: Any) -> dict[str, Any]:
    """A value as a notebook shows it."""
    if isinstance(value, Figure):
        picture = io.BytesIO()
        value.savefig(picture, format="png", dpi=DPI, bbox_inches="tight", metadata={"Software": None})
        return {"image/png": base64.b64encode(picture.getvalue()).decode(), "text/plain": ["<Figure>"]}
    shown = {"text/plain": _lines(repr(value))}
    html = getattr(value, "_repr_html_", lambda: None)()
    return shown if html is None else {"text/html": _lines(html), **shown}


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def write(notebook: dict[str, Any], path: Path = NOTEBOOK) -> None:
    """Write a notebook as Jupyter does."""
    path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main() -> None:
    """Run all, and keep it."""
    mpl.use("agg")
    notebook = read()
    for number, (cell, outputs) in enumerate(run(notebook), start=1):
        cell["outputs"], cell["execution_count"] = outputs, number
        sys.stdout.write(f"cell {number}: {', '.join(output['output_type'] for output in outputs) or 'nothing'}\n")
    write(notebook)


if __name__ == "__main__":
    main()
