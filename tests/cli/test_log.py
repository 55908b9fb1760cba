"""`--verbose` and `--log-file`: what is said, and what is done."""

from __future__ import annotations

import logging

import pytest

FLY = ("fly", "straight.toml", "--flights", "3")


@pytest.mark.usefixtures("faked")
def test_a_log_file_has_what_is_said_and_done_with_times(hotlap, here):
    ran = hotlap(*FLY, "--log-file", "mine.log")
    lines = (here / "mine.log").read_text().splitlines()
    assert all(line[:4].isdigit() for line in lines)
    assert "hotlap fly straight.toml --flights 3 --log-file mine.log" in lines[0]
    assert f"caches in {here / 'cache'}" in lines[1]
    assert ran.err
    assert all(any(said in line for line in lines) for said in ran.err.splitlines())
    assert "done after" in lines[-1]


@pytest.mark.usefixtures("faked")
def test_verbose_says_how_long_things_take_and_leaves_the_result_alone(hotlap):
    plain, verbose = hotlap(*FLY), hotlap(*FLY, "--verbose")
    assert verbose.out == plain.out
    assert set(plain.err.splitlines()) < set(verbose.err.splitlines())
    assert "done after" in verbose.err
    assert hotlap(*FLY).err == plain.err, "nothing of it stays"


def test_an_error_is_one_line_and_in_the_log_where_it_arose(hotlap, here):
    ran = hotlap("check", "missing.toml", "--log-file", "mine.log")
    assert ran.err == "hotlap: missing.toml: there is no such file\n"
    log = (here / "mine.log").read_text()
    assert "ERROR missing.toml: there is no such file\n" in log
    assert "Traceback" in log
    assert "Traceback" in hotlap("check", "missing.toml", "--verbose").err


def test_further_commands_are_appended(hotlap, here):
    for name in ("circle", "hummingbird"):
        hotlap("check", name, "--log-file", "mine.log")
    log = (here / "mine.log").read_text()
    assert log.index("hotlap check circle ") < log.index("hotlap check hummingbird ")


def test_a_log_that_cannot_be_written_is_one_line(hotlap, here):
    ran = hotlap("check", "circle", "--log-file", "nowhere/mine.log")
    assert (ran.code, ran.out, ran.err) == (2, "", "hotlap: nowhere/mine.log: cannot be written: No such file or directory\n")
    assert not (here / "nowhere").exists()


def test_nothing_stays_of_a_log(hotlap):
    before = logging.getLogger("hotlap").handlers[:]
    hotlap("check", "circle", "--verbose")
    assert logging.getLogger("hotlap").handlers == before
