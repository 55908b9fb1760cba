"""`python -m hotlap`, where the program itself is not on the path."""

import sys

from hotlap.cli.main import main

sys.exit(main())
