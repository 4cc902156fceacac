"""Equations as MathML, which browsers draw by themselves: no script and nothing from the network.

Docutils translates the TeX that pages hold (`docutils.utils.math.latex2mathml`).
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.math import get_node_equation_number


def visit_math(translator: Any, node: nodes.Element) -> None:
    """An equation in a line of text."""
    translator.body.append(_mathml(node))
    raise nodes.SkipNode


def visit_displayed(translator: Any, node: nodes.Element) -> None:
    """An equation of its own, with its number where it has a label."""
    translator.body.append(translator.starttag(node, "div", CLASS="equation"))
    translator.body.append(_mathml(node, as_block=True))
    if node["number"]:
        translator.body.append(f'<span class="eqno">({get_node_equation_number(translator, node)})</span>')
    translator.body.append("</div>")
    raise nodes.SkipNode


def _mathml(node: nodes.Element, as_block: bool = False) -> str:
    try:
        mathml: str = tex2mathml(node.astext(), as_block=as_block)
    except MathError as error:
        raise ExtensionError(f"equation: expected TeX that docutils knows, got {node.astext()!r} ({error})") from error
    return mathml


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displayed, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
