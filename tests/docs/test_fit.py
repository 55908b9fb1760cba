"""Every page of the documentation fits phones and screens of three widths, and can be read by anybody."""

from __future__ import annotations

import pytest

from report.test_browser import drive, tools  # noqa: F401

pytest.importorskip("sphinx", reason="make docs installs it")
pytestmark = pytest.mark.check


def test_nothing_is_cut_and_axe_finds_nothing_serious(built):
    drive("browser/docs.mjs", str(built), "--axe")
