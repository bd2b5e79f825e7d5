"""Equations as MathML, which browsers draw without a script and without a network. Docutils translates them."""

import re
from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)
THIN = '<mspace width="0.1667em"></mspace>'
BETTER = (  # what docutils leaves: primes that are apostrophes, and no space around the names of functions
    (r"<mo>'</mo>", "<mo>′</mo>"),
    (r"(</m(?:i|n|sub|sup|frac)>)(?=\s*<mi>\w+</mi>\s*<mo>&ApplyFunction;)", rf"\1{THIN}"),
    (r"<mo>&ApplyFunction;</mo>(?!\s*<mo stretchy=\"false\">[(|])", THIN),
)


def translated(node: nodes.math | nodes.math_block, *, block: bool) -> str:
    """The MathML of an equation; a warning, which ends the build, where docutils does not know its LaTeX."""
    source = node.astext()
    try:
        root = latex2mathml.tex2mathml(source, as_block=block)
    except Exception as error:  # docutils raises more than its own MathError
        LOGGER.warning("equation %r: %s", source, error, location=node)
        return ""
    text = str(root)
    for found, better in BETTER:
        text = re.sub(found, better, text)
    return text


def visit_inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(translated(node, block=False))
    raise nodes.SkipNode


def visit_block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(translator.starttag(node, "div", CLASS="math", ids=[]))
    translator.body.append(translated(node, block=True))
    if number := node["number"]:
        translator.body.append(f'<span class="eqno">({number})')
        translator.add_permalink_ref(node, "Link to this equation")
        translator.body.append("</span>")
    translator.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
