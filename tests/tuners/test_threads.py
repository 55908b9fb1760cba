"""Linear algebra keeps to one thread where that is asked for, and only there."""

from __future__ import annotations

from threadpoolctl import ThreadpoolController

from hotlap.tuners.surrogates.threads import one_thread


def test_linear_algebra_keeps_to_one_thread_and_is_given_back():
    controller = ThreadpoolController()
    before = [library.num_threads for library in controller.lib_controllers]
    with one_thread():
        blas = [library for library in controller.lib_controllers if library.user_api == "blas"]
        assert [library.num_threads for library in blas] == [1] * len(blas) != []
    assert [library.num_threads for library in controller.lib_controllers] == before
