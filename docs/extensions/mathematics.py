"""Mathematics: formulas as MathML, which every browser draws by itself: no script and no network."""

from __future__ import annotations

import re
from typing import Literal

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

BAR = re.compile(r"<mo>(?=&#x0(2016|007C);</mo>)")  # of a norm, an absolute value
UNREAD = re.compile(r"<m[ion]>(&(?![#\w])|\\)")  # what the converter left as it was

logger = logging.getLogger(__name__)


def mathml(node: nodes.Node, display: Literal["inline", "block"]) -> str:
    """A formula, or a warning where it is not understood."""
    written = convert(node.astext().replace("{aligned}", "{align*}"), display=display)
    written = BAR.sub('<mo stretchy="false">', written)  # else the left one grows with the line, and the right one does not
    if UNREAD.search(written):
        logger.warning("a formula was not understood: %s", node.astext(), location=node)
    return written


def visit_inline(translator: HTML5Translator, node: nodes.math) -> None:
    """A formula within a line."""
    translator.body.append(mathml(node, "inline"))
    raise nodes.SkipNode


def visit_block(translator: HTML5Translator, node: nodes.math_block) -> None:
    """A formula by itself."""
    translator.body.append(f'<div class="math block">{mathml(node, "block")}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the renderer `mathml`."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
