import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_parameters, save_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.reference.segmentation import SegmentClass, Segments

NAMES = ("Q_pos_xy", "horizon")


def saved(values, starts=(0.0, 2.1), duration=4.0):
    classes = tuple(list(SegmentClass)[i % 4] for i in range(len(starts)))
    return SavedParameters(
        "circle-34", NAMES, Segments(np.array(starts), classes, duration), np.array(values), {"seed": 3, "hotlap": "0.1"}
    )


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(*[st.floats(-1e300, 1e300)] * 2), min_size=1, max_size=5), st.floats(0.1, 100))
def test_parameters_read_back_bit_for_bit(tmp_path, values, duration):
    starts = np.linspace(0, duration, len(values) + 1)
    parameters = saved(values, starts[:-1], float(starts[-1]))
    save_parameters(tmp_path / "p.toml", parameters)
    again = load_parameters(tmp_path / "p.toml")
    assert again.values.tobytes() == parameters.values.tobytes()
    assert again.segments.starts.tobytes() == parameters.segments.starts.tobytes()
    assert again.segments.classes == parameters.segments.classes
    assert again.segments.duration == parameters.segments.duration
    assert (again.race, again.names, again.provenance) == (parameters.race, parameters.names, parameters.provenance)


def test_a_segment_of_several_pieces_is_one_table_with_lists_of_times(tmp_path):
    kinds = (SegmentClass.ASCENT, SegmentClass.FLAT, SegmentClass.ASCENT)
    segments = Segments(np.array([0.0, 1.1, 2.3]), kinds, 4.0, (0, 1, 0))
    save_parameters(tmp_path / "p.toml", SavedParameters("circle-34", NAMES, segments, np.array([[1.0, 2.0], [3.0, 4.0]])))
    assert 'class = "ascent"\nstart = [0.0, 2.3]\nend = [1.1, 4.0]\nQ_pos_xy = 1.0\n' in (tmp_path / "p.toml").read_text()
    again = load_parameters(tmp_path / "p.toml")
    assert (again.segments.classes, again.segments.owners, again.segments.duration) == (kinds, (0, 1, 0), 4.0)
    assert again.segments.starts.tolist() == segments.starts.tolist()
    assert again.values.tolist() == [[1, 2], [3, 4]]


def test_a_studys_folder_stands_for_the_file_in_it(tmp_path):
    save_parameters(tmp_path / "parameters.toml", saved([[1.0, 2.0], [3.0, 4.0]]))
    assert np.array_equal(load_parameters(tmp_path).values, [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('"flat"', '"flt"', "segment[0].class"),
        ("Q_pos_xy = 1.0", "Q_pos = 1.0", "segment[0].Q_pos"),
        ("horizon = 4.0", "", "segment[1].horizon"),
        ("horizon = 4.0", "horizon = nan", "segment[1].horizon"),
        ("horizon = 4.0", "horizon = true", "segment[1].horizon"),
        ("horizon = 4.0", "horizon = 1" + "0" * 400, "segment[1].horizon"),
        ("start = 2.1", "start = 2.2", "segment[1].start"),
        ("end = 4.0", "end = 2.0", "segment[1].end"),
        ("end = 4.0", "end = [4.0, 5.0]", "segment[1].end"),
        ("start = 2.1\nend = 4.0", "start = []\nend = []", "segment[1].end"),
        ("start = 2.1\nend = 4.0", "start = [2.1, 4.5]\nend = [4.0, 5.0]", "segment[1].start"),
        ("start = 2.1\nend = 4.0", "start = [2.1, true]\nend = [4.0, 5.0]", "segment[1].start"),
        ('"horizon"]', '"class"]', "names"),
        ("names =", "nams =", "nams"),
        ("race =", "rase =", "rase"),
        ("[[segment]]", "[[segmnt]]", "segmnt"),
    ],
)
def test_a_faulty_file_is_refused_with_its_key(tmp_path, old, new, key):
    path = tmp_path / "p.toml"
    save_parameters(path, saved([[1.0, 2.0], [3.0, 4.0]]))
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_parameters(path)
    assert (caught.value.source, caught.value.key) == (str(path), key)


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(InputError, match=r"parameters\.toml: there is no such file"):
        load_parameters(tmp_path)
