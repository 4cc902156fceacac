"""The page of a rotor that was drawn: figures with what they show in words, tables, and the command that made it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from html import escape

from bench.reports.page import STYLE, figure_block, table_block
from ksmea.show.rotordynamics import bearing_table, critical_speed_table, mode_table, sentences
from ksmea.whirl import Rotordynamics

TITLES = {  # of the figures: heading and what they show
    "rotor": (
        "Rotor to scale",
        "Shaft sections, disks, bearings, unbalance planes and probes, with lengths between them.",
    ),
    "campbell": (
        "Campbell diagram",
        "Natural frequencies by direction of whirl. Circles: critical speeds with amplification factors (AF); squares: harmonics.",
    ),
    "stability": ("Stability", "Logarithmic decrement of each mode over speed. Below zero the motion grows."),
    "speed_map": (
        "Undamped critical speed map",
        "Critical speeds on bearings of one stiffness in x and y. Dotted lines are the stiffnesses of the model.",
    ),
    "orbits": ("Mode shapes: orbits", "Orbits along the shaft by direction, and the deflected shaft at one moment."),
    "deflections": (
        "Mode shapes: deflection lines",
        "Deflection in x and in y at the moment at which each is largest. Circles are nodes, dotted lines bearings.",
    ),
}


def rotor_page(found: Rotordynamics, pictures: Mapping[str, bytes], words: Sequence[str]) -> str:
    """The page in one file; what is from outside, such as names, is escaped."""
    said = "".join(f"<p>{escape(sentence)}</p>" for sentence in sentences(found))
    figures = {name: figure_block(*TITLES[name], picture) for name, picture in pictures.items()}
    tables = {
        "rotor": table_block("Bearings", bearing_table(found)),
        "campbell": table_block("Critical speeds", critical_speed_table(found)),
        "deflections": table_block("Modes", mode_table(found)),
    }
    blocks = "".join(figure + tables.get(name, "") for name, figure in figures.items())
    command = escape(shlex.join(["python", "-m", "bench", "draw", *words]))
    title = escape(found.title)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head>'
        f"<body><main><h1>{title}</h1>{said}{blocks}<h2>Made by</h2><p><code>{command}</code></p></main></body></html>\n"
    )
