"""The notebook of the documentation runs, and gives what it says."""

from __future__ import annotations

import matplotlib as mpl
import pytest

from docs.pages import program

pytest.importorskip("pandas", reason="the notebook shows data frames")
notebook, transcript = program("notebook"), program("transcript")
page = program("extensions/notebooks")
LARGEST = 400_000  # bytes of the file


def outline(output: dict) -> tuple[str, list[str], str]:
    """What an output is, in which forms, and its words without digits."""
    data = output.get("data", {})
    text = "".join(output.get("text", data.get("text/plain", [])))
    return output["output_type"], sorted(data), transcript.outline(text)


@pytest.mark.check
def test_every_cell_runs_and_gives_what_is_kept():
    mpl.use("agg")
    for cell, outputs in notebook.run(notebook.read()):
        kept = cell["outputs"]
        assert list(map(outline, outputs)) == list(map(outline, kept)), "".join(cell["source"])


def test_every_cell_has_been_run_in_order_and_the_file_is_small():
    cells = notebook.code_cells(notebook.read())
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    assert not [output for cell in cells for output in cell["outputs"] if output["output_type"] == "error"]
    assert notebook.NOTEBOOK.stat().st_size < LARGEST


def test_a_notebook_is_written_as_jupyter_reads_it(tmp_path):
    kept = notebook.read()
    assert (kept["nbformat"], kept["metadata"]["kernelspec"]["language"]) == (4, "python")
    notebook.write(kept, tmp_path / "again.ipynb")
    assert (tmp_path / "again.ipynb").read_text(encoding="utf-8") == notebook.NOTEBOOK.read_text(encoding="utf-8")


def test_a_cell_gives_what_it_prints_and_its_last_value():
    cells = [{"cell_type": "code", "source": source} for source in (["x = 3\n", "print(x)\n", "x + 1"], ["x;"], ["y = x"])]
    printed, quiet, none = (outputs for _, outputs in notebook.run({"cells": cells}))
    assert [output["output_type"] for output in printed] == ["stream", "execute_result"]
    assert printed[0]["text"] == ["3\n"]
    assert printed[1]["data"]["text/plain"] == ["4"]
    assert quiet == none == []


def test_the_page_has_text_code_tables_and_figures():
    text = page.markdown(notebook.read())
    assert text.startswith("# In a notebook")
    for part in ("```python\nimport hotlap\n", "data:image/png;base64,", '<table border="1" class="dataframe">', "no tuner named"):
        assert part in text, part
    assert "<caption>circle-34: completion=1 confirmed</caption>" in text
