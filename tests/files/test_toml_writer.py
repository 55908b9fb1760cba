import math
import tomllib

from hypothesis import given
from hypothesis import strategies as st

from hotlap.files import toml_writer

text = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
scalars = st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | text
values = st.recursive(scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(text, inner, max_size=3), max_leaves=12)


def same(a, b):
    """Equal in type as well, so that 1, 1.0 and true differ, and so do 0.0 and -0.0."""
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return isinstance(b, list) and len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return type(a) is type(b) and a == b and (not isinstance(a, float) or math.copysign(1, a) == math.copysign(1, b))


@given(st.dictionaries(text, values, max_size=5))
def test_what_is_written_reads_back_equal(table):
    assert same(tomllib.loads(toml_writer.write(table)), table)


@given(st.dictionaries(text, values, max_size=5))
def test_lists_of_tables_may_take_a_line_for_each(table):
    written = toml_writer.write(table, inline_lists=True)
    assert same(tomllib.loads(written), table)
    assert "\n[[" not in written


@given(values)
def test_a_value_takes_one_line(value):
    line = toml_writer.write_value(value)
    assert "\n" not in line
    assert same(tomllib.loads(f"x = {line}"), {"x": value})


def test_nothing_is_written_for_none():
    assert toml_writer.write({"a": None, "b": {"c": None, "d": 1}}) == "[b]\nd = 1\n"


def test_gates_take_a_line_each():
    assert toml_writer.write({"gates": [[1.0, 2.0], [3.0, 4.0]]}) == "gates = [\n  [1.0, 2.0],\n  [3.0, 4.0],\n]\n"


def test_poles_take_a_line_each_where_lists_are_inline():
    poles = [{"position": [0.0, 0.75], "radius": 0.015, "top": 1.55}, {"position": [1.0, 0.25], "radius": 0.015, "top": None}]
    written = toml_writer.write({"poles": poles}, inline_lists=True)
    assert written == (
        "poles = [\n  { position = [0.0, 0.75], radius = 0.015, top = 1.55 },\n  { position = [1.0, 0.25], radius = 0.015 },\n]\n"
    )
