"""What a Crazyflie packs into whole numbers comes out as it went in, and as cflib reads it."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from hotlap.real_flight.crazyflie.packed import pack_attitude, pack_state, unpack_attitude, unpack_state

ATTITUDES = np.random.default_rng(1).standard_normal((50, 4))
ATTITUDES /= np.linalg.norm(ATTITUDES, axis=1)[:, None]
FINE = 2e-3  # of 9 bits
DECODE = """
import json, sys
from cflib.utils.encoding import decompress_quaternion
print(json.dumps([list(decompress_quaternion(one)) for one in json.load(sys.stdin)]))
"""


@pytest.mark.parametrize("attitude", [*ATTITUDES[:20], np.array([1.0, 0, 0, 0]), np.array([0, 0, 0, -1.0])])
def test_an_attitude_comes_out_as_it_went_in(attitude):
    back = unpack_attitude(pack_attitude(attitude))
    assert min(np.abs(back - attitude).max(), np.abs(back + attitude).max()) < FINE
    assert np.linalg.norm(back) == pytest.approx(1)


def test_a_state_comes_out_as_it_went_in_and_the_pitch_rate_is_logged_with_the_other_sign():
    state = np.array([1.5, -2.25, 0.75, *ATTITUDES[0], 3.5, -4.0, 0.5, 1.0, 2.0, -3.0])
    state[3:7] *= np.sign(state[3 + np.argmax(np.abs(ATTITUDES[0]))])
    packed = pack_state(state)
    assert packed[7:] == [1000, -2000, -3000]
    assert unpack_state(packed) == pytest.approx(state, abs=FINE)


def test_what_is_too_large_for_sixteen_bits_is_as_large_as_they_hold():
    packed = pack_state(np.array([100.0, -100.0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]))
    assert packed[:2] == [32767, -32767]


@pytest.mark.skipif(find_spec("cflib") is None, reason="needs cflib")
def test_cflib_reads_an_attitude_likewise():
    packed = [pack_attitude(attitude) for attitude in ATTITUDES]
    command = [sys.executable, "-c", DECODE]  # a process of its own, as everywhere
    ran = subprocess.run(command, input=json.dumps(packed), capture_output=True, text=True, check=True)
    theirs = np.roll(json.loads(ran.stdout), 1, axis=1)
    assert theirs == pytest.approx(np.array([unpack_attitude(one) for one in packed]), abs=1e-6)
