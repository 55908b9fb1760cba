"""The public names: few, documented, loaded where they are first used; names of before say where they live now."""

from __future__ import annotations

import subprocess
import sys
import warnings

import pytest

import hotlap

MOST = 18


@pytest.mark.parametrize("name", hotlap.__all__)
def test_every_public_name_is_there_and_documented(name):
    assert getattr(hotlap, name).__doc__
    assert name in dir(hotlap)


def test_the_list_of_public_names_is_short_sorted_and_complete():
    assert hotlap.__all__ == sorted(hotlap._HOME)
    assert len(hotlap.__all__) <= MOST
    with pytest.raises(AttributeError, match="no attribute 'tnue'"):
        hotlap.tnue  # noqa: B018


@pytest.mark.parametrize("name", hotlap._FORMER_HOME)
def test_a_name_of_before_goes_on_working_and_says_where_it_lives(name):
    with pytest.warns(DeprecationWarning, match=rf"hotlap\.{name} is hotlap\.\S+\.{name} now") as caught:
        value = getattr(hotlap, name)
    assert caught[0].filename == __file__
    assert value is getattr(sys.modules[f"hotlap.{hotlap._FORMER_HOME[name]}"], name)
    assert name not in dir(hotlap)


def test_names_of_before_can_be_imported_as_before():
    with pytest.warns(DeprecationWarning, match=r"hotlap\.BuiltIn is hotlap\.worlds\.built_in\.BuiltIn now"):
        from hotlap import BuiltIn  # noqa: PLC0415
    assert BuiltIn().name == "built-in"


def test_a_class_that_was_renamed_and_a_function_that_became_a_method_say_so():
    with pytest.warns(DeprecationWarning, match=r"hotlap\.Course is hotlap\.reference\.scenario\.Scenario now"):
        assert hotlap.Course.__name__ == "Scenario"
    with pytest.raises(AttributeError, match=r"no attribute 'carry_out'; it is hotlap\.study\.study\.Study\.run, a method, now"):
        hotlap.carry_out  # noqa: B018


def test_looking_around_warns_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert all(hasattr(hotlap, name) for name in dir(hotlap))


def test_importing_hotlap_and_naming_its_calls_loads_nothing():
    program = "import sys, hotlap; hotlap.check, hotlap.tune, hotlap.plan, hotlap.fly, hotlap.compare, hotlap.export; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert {"numpy", "pydantic", "numba", "casadi", "rich", "matplotlib"} & {name.partition(".")[0] for name in loaded} == set()
