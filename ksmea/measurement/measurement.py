"""Measured amplitudes or complex responses over speed and channels, with their noise model.

Never the true values.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError, unknown
from ksmea.measurement.campaign import Campaign
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.measurement.notation import Notation
from ksmea.measurement.observable import Observable
from ksmea.measurement.speeds import SpeedHistory
from ksmea.units import DEGREE, MICROMETRE, RPM

if TYPE_CHECKING:
    import pandas as pd

OBSERVABLES = tuple(observable.value for observable in Observable)
KINDS = OBSERVABLES  # name in plugins, for one release


@dataclass(frozen=True)
class Layout:
    """Speeds, channels and observable of a measurement, without its values.

    Args:
        speed: spin speeds (n_speed,), rad/s.
        channels: probes.
        kind: one of `OBSERVABLES`.
        source: file or other source, for messages.
        phase_known: whether the phase origin is known.
        locations: place of each channel in its source, for messages; empty if that has no meaning.
        campaign: runs that the speeds belong to. Default: None, one run.
    """

    speed: Array  # (n_speed,) rad/s
    channels: tuple[Channel, ...]
    kind: str
    source: str
    phase_known: bool = True
    locations: tuple[str, ...] = ()
    campaign: Campaign | None = None

    @property
    def rows(self) -> tuple[slice, ...]:
        """Slice of the speeds of each run."""
        return (slice(0, len(self.speed)),) if self.campaign is None else self.campaign.rows

    @property
    def noise_rows(self) -> tuple[slice, ...]:
        """Slices of the speeds that have an estimated noise level of their own: each run, or all together."""
        return self.rows if self.campaign and self.campaign.own_noise else (slice(0, len(self.speed)),)

    @property
    def breaks(self) -> tuple[int, ...]:
        """Index of the first speed of each further run."""
        return tuple(rows.start for rows in self.rows[1:])

    @property
    def has_free_phase(self) -> bool:
        """Whether its values have phases whose origin is not known."""
        return self.kind == "complex" and not self.phase_known


@dataclass(frozen=True, repr=False)
class Measurement:
    """Measured amplitudes or complex responses over speed and channels, with their noise model.

    Values at other harmonics than 1X need a phase: an amplitude of noise alone is never 0, and a Gaussian likelihood takes it for a
    response (docs/diagnosis.md).

    Args:
        speed: spin speeds (n_speed,), rad/s. Speeds of several runs follow one another in the order of `campaign`.
        channels: probes.
        values: values (n_speed, n_channel), m 0-peak: real amplitudes, or complex responses q of Re(q e^{iΩt}).
        noise: standard deviations. None: the level is not known.
        source: file or other source, for messages.
        phase_known: False if phases were measured from an unknown origin: the angle of the whole response is then one more
            unknown.
        campaign: runs. Default: None, one run.
        history: speed history of a single run. Default: None, unknown or steady states.
        time: time of each speed (n_speed,), s from any origin. Default: None, unknown.
        notation: notation of the file.

    Raises:
        SettingError: shapes do not fit each other, values are not finite, or amplitudes are given at other harmonics than 1X.

    >>> import ksmea
    >>> probe = ksmea.Channel(0.1, "x")
    >>> data = Measurement(np.array([100.0, 200.0]), (probe,), np.array([[1e-6], [3e-6]]), ksmea.Noise(0.05, 0.0), "by hand")
    >>> data.to_frame()["amplitude_um_0pk"].tolist()
    [1.0, 3.0]
    """

    speed: Array
    channels: tuple[Channel, ...]
    values: Array | ComplexArray
    noise: Noise | None
    source: str
    phase_known: bool = True
    campaign: Campaign | None = None
    history: SpeedHistory | None = None
    time: Array | None = None
    notation: Notation = field(default_factory=Notation)

    def __post_init__(self) -> None:
        expected = (len(self.speed), len(self.channels))
        if self.values.shape != expected:
            raise SettingError(
                f"measurement: expected values of shape (n_speed, n_channel) = {expected}, got {self.values.shape}"
            )
        if self.rows[-1].stop != len(self.speed):
            raise SettingError(f"runs: expected {len(self.speed)} speeds in all, got {self.rows[-1].stop}")
        if self.campaign and self.campaign.reference:
            names = [run.name for run in self.campaign.runs]
            if self.campaign.reference not in names:
                raise unknown("run of the reference:", self.campaign.reference, names)
            if self.is_amplitude:
                raise SettingError(
                    "reference: expected phases for differences between runs, got amplitudes; leave it out"
                )
        others = [channel for channel in self.channels if not channel.is_1x]
        if others and self.is_amplitude:
            raise SettingError(
                f"measurement: expected phases with {others[0]}, got amplitudes alone, which are never 0 where there is noise"
                " alone; use complex data, or 1X alone"
            )
        if others and len(others) == len(self.channels):
            raise SettingError(f"measurement: expected 1X with {others[0]}, got none; add it")
        if not np.all(np.isfinite(self.values)):
            raise SettingError(
                "measurement: expected finite values, got NaN or infinity; remove those speeds or channels"
            )

    def to_frame(self) -> pd.DataFrame:
        """Table with the columns of a measurement file, one row per speed and channel.

        Returns:
            Speed in rpm, position in m, amplitude in µm 0-peak. Columns `run`, `phase_lead_deg`, `sigma_um`, `time_s` and
            `harmonic` only if the data have them.
        """
        import pandas as pd  # here, as a run without tables takes less time than this import

        columns: dict[str, Array] = {}
        if self.campaign is not None:
            names = [run.name for run in self.campaign.runs for _ in range(run.n_speed)]
            columns["run"] = np.array(names, dtype=object)[:, None]
        columns["speed_rpm"] = self.speed[:, None] / RPM
        columns["position_m"] = np.array([channel.position for channel in self.channels])
        columns["direction"] = np.array([channel.direction for channel in self.channels], dtype=object)
        columns["amplitude_um_0pk"] = np.abs(self.values) / MICROMETRE
        if not self.is_amplitude:
            columns["phase_lead_deg"] = np.angle(self.values) / DEGREE
        if self.noise is not None and self.has_noise:
            columns["sigma_um"] = self.noise.sd(np.abs(self.values)) / MICROMETRE
        if self.time is not None:
            columns["time_s"] = self.time[:, None]
        if not all(channel.is_1x for channel in self.channels):
            columns["harmonic"] = np.array([channel.harmonic for channel in self.channels])
        shape = self.values.shape
        return pd.DataFrame({name: np.broadcast_to(each, shape).ravel() for name, each in columns.items()})

    def __repr__(self) -> str:
        ends = f" from {min(self.speed) / RPM:.0f} to {max(self.speed) / RPM:.0f} rpm" if len(self.speed) else ""
        channels = ", ".join(map(str, self.channels))
        runs = f"{len(self.campaign.runs)} runs, " if self.campaign else ""
        return f"<Measurement {self.source}: {runs}{len(self.speed)} speeds{ends}, {self.kind} at {channels}>"

    def _repr_html_(self) -> str:
        return (
            f"<p>{escape(repr(self)[1:-1])}</p>{self.to_frame().to_html(index=False, max_rows=10, float_format='%.4g')}"
        )

    def by_run(self, noise: Noise) -> tuple[tuple[str, float, float], ...]:
        """Name, relative part and floor (m) of each run, if each has noise levels of its own.

        Args:
            noise: noise of this measurement.
        """
        names = [run.name for run in self.campaign.runs] if noise.rows and self.campaign else []
        return tuple((name, *level) for name, level in zip(names, noise.levels))

    @property
    def has_noise(self) -> bool:
        """Whether noise of a known level is in the values."""
        return self.noise is not None and not self.noise.is_absent

    @property
    def kind(self) -> Observable:
        """Observable: amplitude or complex."""
        return Observable.COMPLEX if np.iscomplexobj(self.values) else Observable.AMPLITUDE

    @property
    def is_amplitude(self) -> bool:
        """Whether the values are amplitudes without phase."""
        return self.kind is Observable.AMPLITUDE

    @property
    def is_by_differences(self) -> bool:
        """Whether its runs are compared with each other alone (`ksmea.likelihood.difference_likelihood`)."""
        return self.campaign is not None and bool(self.campaign.reference)

    @property
    def layout(self) -> Layout:
        """Layout of the measurement: speeds, channels, observable."""
        return Layout(self.speed, self.channels, self.kind, self.source, self.phase_known, campaign=self.campaign)

    @property
    def rows(self) -> tuple[slice, ...]:
        """Slice of the speeds of each run."""
        return self.layout.rows

    @property
    def breaks(self) -> tuple[int, ...]:
        """Index of the first speed of each further run."""
        return self.layout.breaks

    def part(self, indices: Indices) -> Measurement:
        """Measurement at some of its speeds.

        Args:
            indices: rising indices of speeds.
        """
        return dataclasses.replace(
            self,
            speed=self.speed[indices],
            values=self.values[indices],
            noise=None if self.noise is None else self.noise.part(indices),
            campaign=None if self.campaign is None else self.campaign.part(indices),
            time=None if self.time is None else self.time[indices],
        )

    def through(self, kept: Sequence[int]) -> Measurement:
        """Measurement by some of its channels.

        Args:
            kept: indices of channels.
        """
        noise = self.noise
        if noise is not None and np.ndim(noise.floor) and np.shape(noise.floor)[1] == len(self.channels):
            noise = dataclasses.replace(noise, floor=np.asarray(noise.floor)[:, kept])
        channels = tuple(self.channels[index] for index in kept)
        return dataclasses.replace(self, channels=channels, values=self.values[:, kept], noise=noise)

    @property
    def dimensions(self) -> int:
        """Real numbers of a datum."""
        return self.kind.dimensions

    def seen(self, response: ComplexArray) -> Array | ComplexArray:
        """Observable part of a complex response, without noise: all of it, or its amplitude.

        Args:
            response: complex response (n_speed, n_channel), m.
        """
        return self.kind.seen(response)


def observe(response: ComplexArray, kind: str, noise: Noise, rng: np.random.Generator) -> Array | ComplexArray:
    """Noisy data (n_speed, n_channel) of a kind ('amplitude' or 'complex') of a response, m.

    Amplitude noise that would make an amplitude negative is folded back: no instrument shows one. Both kinds draw equal numbers
    from `rng`, so that they differ in kind only.
    """
    first, second = rng.standard_normal((2, *response.shape))
    amplitude = np.abs(response)
    if Observable(kind) is Observable.AMPLITUDE:
        return np.asarray(np.abs(amplitude + noise.sd(amplitude) * first))
    return np.asarray(response + noise.sd(amplitude) * (first + 1j * second) / np.sqrt(2))
