"""What all figures have alike; they are drawn without a display."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.arrays import Array

OURS, PAPER, REFERENCE, INTERVAL = "#2b6ca3", "#c8501e", "#444444", "#3a8f4d"
# Told apart by colour-blind readers too: Okabe & Ito, *Color Universal Design*, 2008; yellow, which is pale on white, left out.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = "osD^vPX*<>hdp8"


class ShownFigure(Figure):
    """A figure that a notebook shows by itself, whatever its drawing backend."""

    def _repr_png_(self) -> bytes:
        return png(self)


def png(figure: Figure) -> bytes:
    """A figure as the content of a PNG file."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=130)
    return content.getvalue()


def broken(values: Array, breaks: Sequence[int]) -> Array:
    """Values to be drawn as one line for each run: not a number before each further run.

    >>> broken(np.array([1.0, 2.0, 1.0, 2.0]), [2])
    array([ 1.,  2., nan,  1.,  2.])
    """
    return np.insert(np.asarray(values, dtype=float), list(breaks), np.nan)


def figure_of(axes: Axes) -> Figure:
    """The figure that axes belong to."""
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("axes: expected axes of a figure, got some that were removed from theirs; make new ones")
    return figure
