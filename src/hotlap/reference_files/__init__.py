"""References of other people, as files: reading, checking, completing and writing them.

    read_table -> check_columns -> in_track_frame -> complete -> Reference

`csv` is the way in and out.
"""
