"""Report: pictures, pages and films of plans and studies.

    study, flights -> scene, history (plain data) -> figures (matplotlib) -> pictures (files)
    reference -> map (text)
    scene -> projection (geometry of all drawings of a track)

Data are prepared in modules of their own, so that pictures, page and film show the same. No package below imports this one.
"""
