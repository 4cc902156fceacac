"""What all figures have alike; they are drawn without a display."""

from __future__ import annotations

import io

from matplotlib.axes import Axes
from matplotlib.figure import Figure

OURS, PAPER, REFERENCE, INTERVAL = "#2b6ca3", "#c8501e", "#444444", "#3a8f4d"


class ShownFigure(Figure):
    """A figure that a notebook shows by itself, whatever its drawing backend."""

    def _repr_png_(self) -> bytes:
        return png(self)


def png(figure: Figure) -> bytes:
    """A figure as the content of a PNG file."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=130)
    return content.getvalue()


def figure_of(axes: Axes) -> Figure:
    """The figure that axes belong to."""
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("axes: expected axes of a figure, got some that were removed from theirs; make new ones")
    return figure
