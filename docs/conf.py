"""How the documentation is built: `make docs`, or `python -m sphinx -W -n docs build/docs`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from hotlap.core.version import __version__

project = "hotlap"
author = "The hotlap authors"
copyright = author  # noqa: A001  Sphinx's word for it
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "extensions.accessible",
    "extensions.commands",
    "extensions.docstrings",
    "extensions.interface",
    "extensions.mathematics",
    "extensions.notebooks",
    "extensions.pairs",
]
exclude_patterns = ["extensions"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
autodoc_mock_imports = ["crazyflow", "drone_models", "jax", "mujoco", "rotorpy"]  # simulators that need not be installed
autodoc_typehints_format = "short"
default_role = "code"
napoleon_numpy_docstring = False

nitpicky = True
nitpick_ignore_regex = [
    (r"py:class", r".*"),  # annotations, of which many lead out of what is described here
    (r"py:.*", r"(?!hotlap\.).*"),  # no other project's inventory is fetched: a build needs no network
]

smartquotes_action = "qe"  # quotes and dots; two dashes begin an option

html_theme = "furo"
html_title = "hotlap"
html_static_path = ["style"]
html_css_files = ["page.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
