"""Platforms: what hotlap runs on."""

from __future__ import annotations

import sys

WINDOWS = (
    "hotlap runs on Linux and macOS, not on Windows itself; on Windows it runs in WSL: wsl --install, then in the Ubuntu that opens "
    "install Python and hotlap as on Linux"
)


def unsupported() -> str:
    """Why hotlap cannot run here, and what to do; "" where it can."""
    return WINDOWS if sys.platform == "win32" else ""
