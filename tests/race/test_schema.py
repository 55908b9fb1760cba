import pytest
from pydantic import ValidationError

from hotlap.race.schema import Described, NotNegative, Positive


class Thing(Described):
    size: Positive
    weight: NotNegative = 1.0


def test_a_description_is_frozen():
    with pytest.raises(ValidationError, match="frozen"):
        Thing(size=1.0).size = 2.0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 0.0])
def test_a_positive_number_is_finite_and_above_zero(value):
    with pytest.raises(ValidationError):
        Thing(size=value)


def test_an_unknown_key_is_refused():
    with pytest.raises(ValidationError, match="colour"):
        Thing(size=1.0, colour=2.0)


def test_the_fingerprint_depends_on_values_alone():
    assert Thing(size=1.0).fingerprint == Thing(size=1, weight=1.0).fingerprint
    assert Thing(size=1.0).fingerprint != Thing(size=1.0000000000000002).fingerprint
    assert len(Thing(size=1.0).fingerprint) == 16
