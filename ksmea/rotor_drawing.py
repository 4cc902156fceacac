"""Result of `rotor.draw()`: the rotor and its whirl as figures, tables and text."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.errors import unknown
from ksmea.rotordynamics.whirl import Rotordynamics
from ksmea.show import rotordynamics_text
from ksmea.show.charts.mode_shape_charts import deflections_chart, orbits_chart
from ksmea.show.charts.picture import drawn
from ksmea.show.charts.rotor_chart import rotor_chart
from ksmea.show.charts.whirl_charts import campbell_chart, speed_map_chart, stability_chart


@dataclass(frozen=True, eq=False)
class RotorDrawing:
    """Rotor at given values of its unknowns, as figures, tables and text.

    Each figure is drawn on given axes or on its own.

    Args:
        record: all numbers, SI.
    """

    record: Rotordynamics

    def plot(self, axes: Axes | None = None) -> Figure:
        """Rotor to scale.

        Args:
            axes: axes to draw on. Default: a new figure.
        """
        return drawn(rotor_chart(self.record.layout, self.record.title), axes)

    def plot_campbell(self, axes: Axes | None = None) -> Figure:
        """Natural frequencies over speed, with the critical speeds.

        Args:
            axes: axes to draw on. Default: a new figure.
        """
        return drawn(campbell_chart(self.record), axes)

    def plot_stability(self, axes: Axes | None = None) -> Figure:
        """Logarithmic decrements over speed.

        Args:
            axes: axes to draw on. Default: a new figure.
        """
        return drawn(stability_chart(self.record), axes)

    def plot_speed_map(self, axes: Axes | None = None) -> Figure:
        """Undamped critical speeds over the stiffness of the bearings.

        Args:
            axes: axes to draw on. Default: a new figure.

        Raises:
            SettingError: the bearings do not hold the rotor.
        """
        return drawn(speed_map_chart(self.record), axes)

    def plot_orbits(self) -> Figure:
        """Mode shapes in space."""
        return drawn(orbits_chart(self.record))

    def plot_deflections(self) -> Figure:
        """Mode shapes as lines of deflection in x and in y."""
        return drawn(deflections_chart(self.record))

    def to_frame(self, name: str = "critical_speeds") -> pd.DataFrame:
        """Numbers behind a figure.

        Args:
            name: critical_speeds, rotor, campbell, speed_map or mode_shapes.

        Raises:
            SettingError: a table of another name.
        """
        if name not in rotordynamics_text.FRAMES:
            raise unknown("table of a drawing:", name, rotordynamics_text.FRAMES)
        return rotordynamics_text.FRAMES[name](self.record)

    def __str__(self) -> str:
        return rotordynamics_text.text(self.record)

    def _repr_html_(self) -> str:
        said = escape(" ".join(rotordynamics_text.sentences(self.record)))
        return f"{rotordynamics_text.critical_speed_table(self.record).to_html(index=False)}<p>{said}</p>"
