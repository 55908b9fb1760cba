"""Report: what a plan or a study looks like.

    study, flights -> scene, history (plain data) -> figures (matplotlib) -> pictures (files)
    reference -> map (text)

Data are prepared apart from drawing, so that every way of showing them shows the same. Nothing below imports this package.
"""
