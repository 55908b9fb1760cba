"""Findings in numbers: what is printed for people is there for programs, in SI units that the names say."""

from __future__ import annotations

import math

import pytest

from hotlap.feasibility import describe
from hotlap.files.descriptions import Kind, load_quadrotor, load_race, load_track, names
from printed_figures import check_figures

EVERY = [
    *((load_track, name) for name in names(Kind.TRACK)),
    *((load_quadrotor, name) for name in names(Kind.QUADROTOR)),
    *((load_race, name) for name in names(Kind.RACE)),
]


@pytest.mark.parametrize(("load", "name"), EVERY, ids=[name for _, name in EVERY])
def test_what_is_printed_is_there_in_numbers(load, name):
    for finding in describe(load(name)):
        check_figures(finding)


def test_a_figure_that_does_not_exist_is_infinite_and_null_in_json():
    speed = next(finding for finding in describe(load_quadrotor("hummingbird")) if finding.label == "top speed")
    assert (speed.value == "-") == (speed.figures["top_speed_m_per_s"] == math.inf)
