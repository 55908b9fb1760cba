"""One call for each main job: `check`, `tune`, `plan`, `fly`, `compare`, `export`, as `hotlap.tune(...)`; the command line calls the same.

    checking, tuning, planning, flying, comparing, exporting, importing   the calls: signatures, defaults, meanings; quick to import
    checked, tuned, planned, flown, compared, exported, imported          the work and its result

The defaults and the help of the command line are read from the signatures and docstrings of the calls.
"""
