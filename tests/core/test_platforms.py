"""What hotlap runs on: on Windows one line says how."""

from __future__ import annotations

import pytest

import hotlap
from hotlap.cli import main
from hotlap.core.platforms import unsupported


def test_here_it_runs():
    assert unsupported() == ""


def test_windows_is_told_of_wsl_in_one_line(monkeypatch, capsys):
    monkeypatch.setattr("sys.platform", "win32")
    assert main(["tune", "circle-34"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "wsl --install" in err


def test_windows_is_told_in_python_too(monkeypatch):
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.delitem(vars(hotlap), "tune", raising=False)
    with pytest.raises(ImportError, match="wsl --install"):
        hotlap.tune  # noqa: B018
