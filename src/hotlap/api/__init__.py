"""One call for each main job: `tune`, `plan`, `fly`, `compare`, `export`, as `hotlap.tune(...)`; the command line calls the same.

    tuning, planning, flying, comparing, exporting, importing   the calls: signatures, defaults, what each argument means; quick to import
    tuned, planned, flown, compared, exported, imported         the work and its result

The defaults and the help of the command line are read from the signatures and docstrings of the calls.
"""
