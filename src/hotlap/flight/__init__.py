"""The flight core: closed-loop flights of controller and plant, many at once."""

from hotlap.system.numba_start import start_numba

start_numba()
