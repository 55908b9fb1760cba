"""A start of Numba that is quicker, and takes no settings from the working folder."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec

BLAS, USER = "scipy.linalg.cython_blas", "numba.np.arraymath"
CONFIG = "numba.core.config"


def start_numba() -> None:
    """Load what Numba needs to compile anything at all, but not `scipy.linalg`, which takes a fifth of a second.

    Numba loads it only to see that it is there. Compiled code that multiplies matrices loads it again, when it is compiled. Nor is
    `.numba_config.yaml` read, settings of the compiler in whatever folder one works in: it may be anybody's.
    """
    if USER in sys.modules or find_spec("numba") is None:
        return
    with warnings.catch_warnings(), _missing("yaml", *({BLAS} - sys.modules.keys())):
        warnings.filterwarnings("ignore", ".*YAML parsing")
        module = import_module(USER)
    vars(module)["_HAVE_BLAS"] = find_spec("scipy") is not None
    vars(import_module(CONFIG))["_config_fname"] = ""  # it is looked at again with everything that is compiled


@contextmanager
def _missing(*names: str) -> Iterator[None]:
    """Modules that cannot be imported for a while."""
    before = {name: sys.modules[name] for name in names if name in sys.modules}
    sys.modules.update(dict.fromkeys(names))  # pyright: ignore[reportArgumentType, reportCallIssue]  the import fails at once
    try:
        yield
    finally:
        for name in names:
            del sys.modules[name]
        sys.modules.update(before)
