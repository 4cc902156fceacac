"""Response curves made by hand, and what a panel draws."""
# Shorter than 40 lines: what two files of tests share.

import msgspec
import numpy as np

from ksmea.records.curves import ResponseCurves
from ksmea.show.charts.chart import Line, Points


def drawn(panel):
    """The lines and points of a panel by their names."""
    return {each.name: each for each in panel.elements if isinstance(each, Line | Points)}


def curves_of(n_speed=4, **others):
    speed = np.linspace(200, 1500, n_speed)
    base = np.outer(np.linspace(1, 2, n_speed), [1e-6, 3e-6])
    data = {"speed": speed.tolist(), "channels": ["x at 0.1 m", "y at 0.1 m"], "true": base.tolist(), **others}
    return msgspec.convert(data, ResponseCurves)
