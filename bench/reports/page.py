"""A page of an experiment in one file: text, tables and figures, without anything from a network, light and dark."""

from __future__ import annotations

import base64
import shlex
from collections.abc import Sequence
from html import escape

import pandas as pd

from bench.plan.plan import Plan

STYLE = """
:root { color-scheme: light dark; --line: #8888; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .25rem .7rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; background: white; }
code { overflow-wrap: anywhere; }
"""


def page(plan: Plan, about: str, blocks: Sequence[str]) -> str:
    """The page of a plan; what is from outside, such as names and values, is escaped."""
    command = shlex.join(["python", "-m", "bench", *plan.command])
    parts = [
        f"<h1>{escape(plan.name)}</h1><p>{escape(about)}</p>",
        *blocks,
        f"<h2>Made by</h2><p><code>{escape(command)}</code></p><p>commit {escape(plan.commit)}</p>",
    ]
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(plan.name)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head>'
        f"<body><main>{''.join(parts)}</main></body></html>\n"
    )


def table_block(title: str, table: pd.DataFrame) -> str:
    """A table of texts, wider than a phone where it must."""
    head = "".join(f'<th scope="col">{escape(str(name))}</th>' for name in table.columns)
    body = "".join(f"<tr>{''.join(f'<td>{escape(str(value))}</td>' for value in row)}</tr>" for row in table.to_numpy())
    whole = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<h2>{escape(title)}</h2><div class="scroll" tabindex="0" role="region" aria-label="{escape(title)}">{whole}</div>'


def figure_block(title: str, alternative: str, png: bytes) -> str:
    """A figure, and in words what it shows."""
    data = base64.b64encode(png).decode()
    return (
        f'<h2>{escape(title)}</h2><figure><img alt="{escape(alternative)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(alternative)}</figcaption></figure>"
    )
