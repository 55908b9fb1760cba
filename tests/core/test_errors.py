import pytest

from hotlap.core.errors import HotlapError, InputError, PlanningError, StudyError, UnknownNameError


def test_an_input_error_says_where_which_and_why():
    error = InputError("racer.toml", "mass", "must be greater than 0")
    assert str(error) == "racer.toml: mass: must be greater than 0"
    assert (error.source, error.key, error.reason) == ("racer.toml", "mass", "must be greater than 0")


def test_an_input_error_leaves_out_what_it_does_not_know():
    assert str(InputError("racer.toml", "", "there is no such file")) == "racer.toml: there is no such file"


def test_an_unknown_name_lists_the_names_that_work_and_the_nearest():
    error = UnknownNameError("race", "circle34", ["flip-16", "circle-34"])
    assert "did you mean circle-34?" in str(error)
    assert error.available == ("circle-34", "flip-16")
    assert str(error).endswith("circle-34, flip-16")


def test_an_unknown_name_far_from_all_gets_no_guess():
    assert "did you mean" not in str(UnknownNameError("race", "zzz", ["flip-16"]))


@pytest.mark.parametrize(("where", "words"), [("gate 3", "no plan for flip, gate 3: no way"), (None, "no plan for flip: no way")])
def test_a_planning_error_names_the_gate(where, words):
    error = PlanningError("flip", where, "no way")
    assert str(error) == words
    assert error.where == where


@pytest.mark.parametrize("kind", [InputError, UnknownNameError, PlanningError, StudyError])
def test_every_error_is_caught_by_the_base(kind):
    assert issubclass(kind, HotlapError)
