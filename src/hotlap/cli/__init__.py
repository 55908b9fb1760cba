"""The command line: parse, call, print.

    main -> arguments (what may be asked) -> races | check | new | plan | tune | fly | bench (one module a command)

Only the module of the command that runs is imported, so that `--help` loads none of the libraries that fly.
"""

from hotlap.cli.main import main

__all__ = ["main"]
