"""Measured and modelled response on a page.

Over speed, in the complex plane, and as orbits of the shaft.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from bench.plan.page import Block, Drawn, Orbits
from ksmea.arrays import ComplexArray
from ksmea.show.charts.chart import Chart
from ksmea.show.charts.response_charts import COLOURS, nyquist_chart
from ksmea.show.charts.responses import ACCEPTED, Response
from ksmea.show.readings import DECIMALS, speed_digits
from ksmea.show.text import two_digits


def response_blocks(response: Response, over_speed: Chart, file: str) -> Iterator[Block]:
    """All plots that a response has."""
    yield Drawn(over_speed, file)
    if response.has_phase:
        yield Drawn(partial(nyquist_chart, response))
        if response.planes():
            yield orbits(response)


def orbits(response: Response) -> Orbits:
    """The orbits of all planes with probes in two directions, measured and by the last model."""
    notation = response.notation
    name, modelled = list(response.at_speeds.items())[-1]
    curves = {"measured": response.measured, "model": modelled}
    difference = np.max(np.abs(curves["measured"] - curves["model"]), axis=1)
    worst = int(np.argmax(difference))
    speed = f"{speed_digits(float(response.speed[worst]), notation)} {notation.speed}"
    return Orbits(
        f"Orbits; {_model(name)} differs most from the data at {speed}, by {two_digits(difference[worst])} {notation.unit}",
        "The path of the shaft in each plane at a speed, measured (dotted) and modelled; dots: position at phase 0.",
        tuple(response.speed.tolist()),
        {
            response.plane_name(place): {
                curve: _phasors(values[:, columns] @ to_xy.T) for curve, values in curves.items()
            }
            for place, (columns, to_xy) in response.planes().items()
        },
        worst,
        notation.amplitude,
        notation.speed,
        DECIMALS[notation.speed],
    )


def _model(name: str) -> str:
    """A model in words: 'the model with the cause', 'the fitted model'."""
    if name == ACCEPTED:
        return f"the {name}"
    return f"the model {name}" if name in COLOURS else f"the {name} model"


def _phasors(values: ComplexArray) -> tuple[tuple[float, float, float, float], ...]:
    """(n_speed, 2) of x and y as (re x, im x, re y, im y)."""
    return tuple((x.real, x.imag, y.real, y.imag) for x, y in values.tolist())
