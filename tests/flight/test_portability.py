"""The flight core is made of vectors on every kind of machine that hotlap runs on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba import njit, typeof

from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.mpc import Mpc, allocate_mpc, solve
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import VehicleState, allocate_vehicle_state, fly_period

LANES = 8
TRIPLES = ("aarch64-unknown-linux-gnu", "arm64-apple-macosx")
HERE = Path(__file__).parent


def run(arguments: list[str], **environment: str) -> str:
    others = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_CPU")}
    command = [sys.executable, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True, env={**others, **environment}).stdout


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"NUMBA_CPU_NAME": "generic"}, "float32x8"),
        ({"NUMBA_CPU_FEATURES": "+sse2,+avx,+avx2,-avx512f"}, "float32x8"),
        ({"NUMBA_CPU_FEATURES": "+avx512f,+avx512vl"}, "float32x16"),
    ],
)
def test_lanes_are_as_many_as_what_numba_compiles_for_can_take(environment, expected):
    program = "from hotlap.flight.numbers import best_numbers; print(best_numbers())"
    assert run(["-c", program], **environment).strip() == expected


@pytest.mark.slow
def test_a_processor_without_wide_vectors_flies_the_same():
    tests = "lanes_fly_as_plain_floats or threads_and_logs or end_in_more_than_one_way or lanes_agree"
    files = [str(HERE / "test_fly.py"), str(HERE / "test_self_check.py")]
    said = run(["-m", "pytest", "-q", "-k", tests, *files], NUMBA_CPU_NAME="generic")
    passed = re.search(r"^(\d+) passed, \d+ deselected", said, re.MULTILINE)
    assert passed is not None, said
    assert int(passed[1]) >= 6


def take_out_x86(assembly: str) -> str:
    """LLVM code that any processor takes: Numba's code generator leaves an x86 intrinsic in its counts of references."""
    count = 0

    def decrement(match: re.Match[str]) -> str:
        nonlocal count
        count += 1
        lines = (
            f"%old.{count} = atomicrmw sub ptr {match['place']}, i64 1 monotonic",
            f"%last.{count} = icmp eq i64 %old.{count}, 1",
            f"{match['result']} = zext i1 %last.{count} to i8",
        )
        return "\n  ".join(lines)

    assembly = re.sub(r'^target (triple|datalayout) = ".*"$', "", assembly, flags=re.MULTILINE)
    call = r"(?P<result>%\S+) = (tail )?call i8 @llvm\.x86\.atomic\.sub\.cc\.i64\(ptr [^%]*(?P<place>%[^,]+), i64 1, i32 4\).*"
    return re.sub(call, decrement, assembly)


@pytest.fixture(scope="module")
def control_period() -> str:
    """LLVM code of a control period: the solver and the plant, on lanes."""

    @njit(**COMPILE, no_cpython_wrapper=True, no_cfunc_wrapper=True)
    def control_period(mpc: Mpc, vehicle_state: VehicleState) -> None:
        solve(as_numbers(borrow(mpc), LANES), 2)
        fly_period(as_numbers(borrow(vehicle_state), LANES), 4)

    signature = typeof(allocate_mpc(4, LANES, np.float32)), typeof(allocate_vehicle_state(LANES, np.float32))
    control_period.compile(signature)
    return take_out_x86(control_period.inspect_llvm(signature))


@pytest.mark.check
@pytest.mark.parametrize("triple", TRIPLES)
def test_arm_flies_in_vectors(control_period, triple):
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu="generic", opt=2)
    module = llvm.parse_assembly(control_period)
    module.triple, module.data_layout = triple, str(machine.target_data)
    assembly = machine.emit_assembly(module)
    multiply_adds = re.findall(r"^\s*fml[as](?:\.4s\s+v\d+|\s+v\d+\.4s)", assembly, re.MULTILINE)
    scalar = re.findall(r"^\s*f(?:madd|msub|nmadd|nmsub|mul|add|sub|div)\s+[sd]\d+", assembly, re.MULTILINE)
    assert len(multiply_adds) > 1000
    assert len(scalar) < 0.01 * len(multiply_adds)
    assert not re.findall(r"\b_?(?:sqrt|sin|cos|exp)f?\b", assembly)  # of a library, one number at a time
