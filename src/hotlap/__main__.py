"""`python -m hotlap`, where the program itself is not on the path.

Python puts the working folder first on its own path; it is taken off before anything else is loaded, so that no file of it is taken for a
library. What Python itself loads before is not ours: `python -P -m hotlap` leaves the folder out from the beginning.
"""

import os
import sys

if not sys.flags.safe_path and sys.path and sys.path[0] in {"", os.getcwd()}:  # noqa: PTH109  pathlib is loaded from the path
    del sys.path[0]

from hotlap.cli.main import main

sys.exit(main())
