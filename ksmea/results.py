"""Results of the Python API: a record with the text of the terminal, a table and a figure.

`print(result)` gives the text, `to_frame()` a tidy table, `plot()` a figure, `to_json()` the record with the unit of
each number; a notebook shows table and text. `record` has every number as an attribute, SI unless its documentation
says otherwise.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Generic, TypeVar

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.errors import unknown
from ksmea.records.balancing import BalanceRecord
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.records.identification import IdentificationRecord
from ksmea.records.location import LocationRecord
from ksmea.records.planning import PlanningRecord
from ksmea.records.record import Record
from ksmea.show import (
    balance_text,
    diagnosis_text,
    identifiability_text,
    identification_text,
    location_text,
    planning_text,
    weights_text,
)
from ksmea.show.charts.identifiability_chart import identifiability_chart
from ksmea.show.charts.picture import drawn
from ksmea.show.charts.planning_chart import planning_chart
from ksmea.show.json_units import with_units

AnyRecord = TypeVar("AnyRecord", bound=Record)


@dataclass(frozen=True)
class Result(ABC, Generic[AnyRecord]):
    """Base of all results.

    Args:
        record: all numbers, SI unless their documentation states another unit.
    """

    record: AnyRecord

    @abstractmethod
    def __str__(self) -> str:
        """Text that the command line prints."""

    @abstractmethod
    def to_frame(self) -> pd.DataFrame:
        """Tidy table, with values in the units that it names."""

    @abstractmethod
    def plot(self, axes: Axes | None = None) -> Figure:
        """Figure that the command line writes.

        Args:
            axes: axes for its main panel. Default: a new figure with all panels.
        """

    def to_json(self, path: str | Path | None = None) -> str:
        """Record as JSON.

        Args:
            path: file to write it to as well.

        Returns:
            JSON text, with the unit of each number (docs/python.md).
        """
        text = json.dumps(with_units(self.record), indent=1, allow_nan=False)
        if path is not None:
            Path(path).write_text(text + "\n", encoding="utf-8")
        return text

    def _repr_html_(self) -> str:
        return f"{self.to_frame().to_html(index=False, float_format='%.4g')}<pre>{escape(str(self))}</pre>"


@dataclass(frozen=True)
class Value:
    """Identified value with its interval; `float(value)` is the number.

    Args:
        name: name of the unknown.
        unit: unit of the three numbers.
        value: identified value.
        low: lower end of the interval; None if it is open.
        high: upper end of the interval; None if it is open.

    >>> print(Value("kxx", "MN/m", 50.2, 48.9, None))
    kxx = 50.2 MN/m [48.9, –]
    """

    name: str
    unit: str
    value: float
    low: float | None
    high: float | None

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        low, high = ("–" if end is None else f"{end:.5g}" for end in (self.low, self.high))
        return f"{self.name} = {self.value:.5g} {self.unit} [{low}, {high}]"


@dataclass(frozen=True)
class IdentificationResult(Result[IdentificationRecord], Mapping[str, Value]):
    """Identified values with their intervals by name.

    `found["kxx"]` is one of them, `dict(found)` has all, and `rotor.response(found)` is the response at them. `to_frame()` has a row
    per unknown, in its unit.

    >>> import ksmea
    >>> from ksmea.testing.jeffcott import JeffcottRotor
    >>> rotor = ksmea.LoadedProblem("jeffcott", JeffcottRotor(), JeffcottRotor().build())
    >>> data = ksmea.synthetic_measurement(rotor, relative=0.02, kind="complex", rng=1)
    >>> found = ksmea.identify(rotor, data)
    >>> found["kxx"].low < 0.9 < found["kxx"].high, found["kxx"].unit
    (True, 'MN/m')
    >>> list(found)
    ['kxx', 'kyy', 'cxx', 'cyy', 'u']
    >>> rotor.prediction(found).query("channel == 'x at 0 m'")["amplitude_sd_um"].round(2).tolist()[:2]
    [0.02, 0.06]
    """

    def __iter__(self) -> Iterator[str]:
        return (item.name for item in self.record.parameters)

    def __len__(self) -> int:
        return len(self.record.parameters)

    def __getitem__(self, name: str) -> Value:
        for item in self.record.parameters:
            if item.name == name:
                low, high = (None if end is None else end / item.si_per_unit for end in (item.low, item.high))
                return Value(name, item.unit, item.value / item.si_per_unit, low, high)
        raise unknown("unknown of the identification:", name, [item.name for item in self.record.parameters])

    def __str__(self) -> str:
        return identification_text.text(self.record, self.record.data.source if self.record.data else "")

    def to_frame(self) -> pd.DataFrame:
        return identification_text.frame(self.record)

    def residuals(self) -> pd.DataFrame:
        """Data and fitted response by speed and channel, with residuals in standard deviations of the noise.

        Residuals are of the amplitude, or along the fitted response and a quarter turn ahead of it.

        Returns:
            One row per speed (rpm) and channel, amplitudes in µm 0-peak, phases in degrees of lead.

        Raises:
            SettingError: the record has no fit.
        """
        return identification_text.residual_frame(self.record)

    def influence(self) -> pd.DataFrame | None:
        """Influence coefficients of the planes of a campaign with weights.

        Returns:
            One row per plane, speed and channel; None for other data.
        """
        return None if self.record.weights is None else weights_text.influence_frame(self.record.weights)

    def plot(self, axes: Axes | None = None) -> Figure:
        return identification_text.plot(self.record, axes)


@dataclass(frozen=True)
class IdentifiabilityResult(Result[IdentifiabilityRecord]):
    """Precision of the unknowns from such data, by the Cramér–Rao lower bound."""

    def __str__(self) -> str:
        return identifiability_text.text(self.record)

    def to_frame(self) -> pd.DataFrame:
        return identifiability_text.frame(self.record)

    def plot(self, axes: Axes | None = None) -> Figure:
        return drawn(identifiability_chart(self.record), axes)


@dataclass(frozen=True)
class PlanResult(Result[PlanningRecord]):
    """Speeds, probes or trial unbalance to add, and their gain in precision."""

    def __str__(self) -> str:
        return planning_text.text(self.record)

    def to_frame(self) -> pd.DataFrame:
        return planning_text.frame(self.record)

    def plot(self, axes: Axes | None = None) -> Figure:
        return drawn(planning_chart({"": self.record}), axes)


@dataclass(frozen=True)
class DiagnosisResult(Result[DiagnosisRecord]):
    """Result of a diagnosis: misfit of the model, explaining effect, and gain on left-out data.

    Args:
        record: all numbers, SI unless their documentation states another unit.
        extended_yaml: file of the extended model, which `load_problem` takes; empty if the verdict names no effect.
    """

    extended_yaml: str = ""

    @property
    def verdict(self) -> str:
        """Verdict: adequate, named, ambiguous, located, unknown or not observable."""
        return self.record.verdict

    @property
    def named(self) -> tuple[str, ...]:
        """Effects that the verdict names."""
        return tuple(self.record.named)

    def __str__(self) -> str:
        return diagnosis_text.text(self.record)

    def to_frame(self) -> pd.DataFrame:
        """Effects in order of how well they explain the data, one row per unknown of each."""
        return diagnosis_text.frame(self.record)

    @property
    def location(self) -> LocationResult | None:
        """Location without the library; None if the model is adequate, or the data are too few."""
        found = self.record.location
        return None if found is None else LocationResult(found, self.extended_yaml if self.verdict == "located" else "")

    def coefficients(self) -> pd.DataFrame:
        """Every unknown before and after the extension, with intervals."""
        return diagnosis_text.coefficients_frame(self.record)

    def plot(self, axes: Axes | None = None) -> Figure:
        return diagnosis_text.plot(self.record, axes)


@dataclass(frozen=True)
class LocationResult(Result[LocationRecord]):
    """Sites at which something acts that the model lacks, and its force over speed.

    Args:
        record: all numbers, SI unless their documentation states another unit.
        extended_yaml: file of the model with the law that holds, which `load_problem` takes; empty if none
            does, and if the cause is spread over the shaft.
    """

    extended_yaml: str = ""

    @property
    def sites(self) -> tuple[float, ...]:
        """Accepted positions, m; both positions of a pair of forces."""
        return tuple(position for site in self.record.sites for position in site.positions)

    def __str__(self) -> str:
        return location_text.text(self.record)

    def to_frame(self) -> pd.DataFrame:
        return location_text.frame(self.record)

    def plot(self, axes: Axes | None = None) -> Figure:
        return location_text.plot(self.record, axes)


@dataclass(frozen=True)
class BalanceResult(Result[BalanceRecord]):
    """Influence coefficients, unknown weights and corrections of a campaign."""

    @property
    def correction(self) -> dict[float, tuple[float, float]]:
        """Correction weight of each plane.

        Returns:
            Size (in the unit of the plane's weights, g mm if the file has none) and angle (degrees), by the position of the
            plane, m.
        """
        found = self.record.correction
        return {position: (each.size, each.angle) for position, each in zip(found.position, found.weight)}

    def __str__(self) -> str:
        return balance_text.text(self.record)

    def to_frame(self) -> pd.DataFrame:
        return balance_text.frame(self.record)

    def plot(self, axes: Axes | None = None) -> Figure:
        return balance_text.plot(self.record, axes)
