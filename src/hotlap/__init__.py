"""Tune the controller of a racing quadrotor so that it flies a track at the limit, and prove it."""

from __future__ import annotations

__version__ = "0.1.0.dev0"
