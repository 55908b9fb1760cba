"""One call for each main job, as `hotlap.tune(...)`; the command line calls the same.

    checking, tuning, planning, flying, transferring, comparing, exporting, importing   signatures, defaults, meanings; quick to import
    checked, tuned, planned, flown, transferred, compared, exported, imported           the work and its result

The defaults and the help of the command line are read from the signatures and docstrings of the calls.
"""
