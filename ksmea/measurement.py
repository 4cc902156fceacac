"""What was measured: amplitudes or complex responses over speed and channels, with their noise model. Never the truth."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.campaign import Campaign
from ksmea.channel import Channel
from ksmea.errors import SettingError
from ksmea.kind import Kind

KINDS = tuple(kind.value for kind in Kind)


@dataclass(frozen=True)
class Noise:
    """Noise with standard deviation s, s² = (relative · |y|)² + floor² (m).

    For complex data s² is the total variance, s/√2 per real and imaginary part; for amplitudes s is the standard
    deviation itself. `floor` is one number, or one per datum (n_speed, n_channel) where the data came with their own.
    """

    relative: float
    floor: float | Array

    def sd(self, amplitude: Array) -> Array:
        """s at amplitudes (…, n_speed, n_channel), m."""
        return np.asarray(np.hypot(self.relative * np.abs(amplitude), self.floor))

    def variance(self, amplitude: Array) -> Array:
        """s², m²."""
        return np.asarray((self.relative * np.abs(amplitude)) ** 2 + np.square(self.floor))

    @property
    def is_absent(self) -> bool:
        return self.relative == 0 and bool(np.all(np.equal(self.floor, 0)))


@dataclass(frozen=True)
class Layout:
    """What is measured, without the values: where, of what kind (one of `KINDS`), and whether it is known where phases
    begin. `locations` says where in its source each channel stands, for messages; empty where that has no meaning.
    `campaign` has the runs that the speeds belong to; None: one run."""

    speed: Array  # (n_speed,) rad/s
    channels: tuple[Channel, ...]
    kind: str
    source: str
    phase_known: bool = True
    locations: tuple[str, ...] = ()
    campaign: Campaign | None = None

    @property
    def rows(self) -> tuple[slice, ...]:
        """Where the speeds of each run lie."""
        return (slice(0, len(self.speed)),) if self.campaign is None else self.campaign.rows

    @property
    def breaks(self) -> tuple[int, ...]:
        """Where the speeds of each further run begin."""
        return tuple(rows.start for rows in self.rows[1:])

    @property
    def has_free_phase(self) -> bool:
        """Whether its values have phases whose origin is not known."""
        return self.kind == "complex" and not self.phase_known


@dataclass(frozen=True)
class Measurement:
    """Values (n_speed, n_channel), m 0-peak: real amplitudes or complex responses, at `speed` (rad/s).

    `noise` is None where its level is not known; `phase_known` is false where phases were measured from an origin that
    nobody knows: the angle of the whole response is one more unknown then. Speeds of several runs stand one run after the
    other, as `campaign` says; without one they are those of one run. `time` (n_speed,) is when each was measured, s from
    any origin; None where nobody says.
    """

    speed: Array
    channels: tuple[Channel, ...]
    values: Array | ComplexArray
    noise: Noise | None
    source: str
    phase_known: bool = True
    campaign: Campaign | None = None
    time: Array | None = None

    def __post_init__(self) -> None:
        expected = (len(self.speed), len(self.channels))
        if self.values.shape != expected:
            raise SettingError(
                f"measurement: expected values of shape (n_speed, n_channel) = {expected}, got {self.values.shape}"
            )
        if self.rows[-1].stop != len(self.speed):
            raise SettingError(f"runs: expected {len(self.speed)} speeds in all, got {self.rows[-1].stop}")
        if not np.all(np.isfinite(self.values)):
            raise SettingError(
                "measurement: expected finite values, got NaN or infinity; remove those speeds or channels"
            )

    @property
    def has_noise(self) -> bool:
        """Whether noise of a known level is in the values."""
        return self.noise is not None and not self.noise.is_absent

    @property
    def kind(self) -> Kind:
        return Kind.COMPLEX if np.iscomplexobj(self.values) else Kind.AMPLITUDE

    @property
    def is_amplitude(self) -> bool:
        return self.kind is Kind.AMPLITUDE

    @property
    def layout(self) -> Layout:
        """What was measured, without the values."""
        return Layout(self.speed, self.channels, self.kind, self.source, self.phase_known, campaign=self.campaign)

    @property
    def rows(self) -> tuple[slice, ...]:
        """Where the speeds of each run lie."""
        return self.layout.rows

    @property
    def breaks(self) -> tuple[int, ...]:
        """Where the speeds of each further run begin."""
        return self.layout.breaks

    def part(self, indices: Indices) -> Measurement:
        """The measurement at some of its speeds, by rising index."""
        noise = self.noise
        if noise is not None and np.ndim(noise.floor):
            noise = Noise(noise.relative, np.asarray(noise.floor)[indices])
        return dataclasses.replace(
            self,
            speed=self.speed[indices],
            values=self.values[indices],
            noise=noise,
            campaign=None if self.campaign is None else self.campaign.part(indices),
            time=None if self.time is None else self.time[indices],
        )

    @property
    def dimensions(self) -> int:
        """Real numbers of a datum."""
        return self.kind.dimensions

    def seen(self, response: ComplexArray) -> Array | ComplexArray:
        """What this measurement shows of a complex response, noise aside: all of it, or its amplitude."""
        return self.kind.seen(response)


def observe(response: ComplexArray, kind: str, noise: Noise, rng: np.random.Generator) -> Array | ComplexArray:
    """Noisy data (n_speed, n_channel) of a kind ('amplitude' or 'complex') of a response, m.

    Amplitude noise that would make an amplitude negative is folded back: no instrument shows one. Both kinds draw
    the same numbers from `rng`, so that they differ in kind only.
    """
    first, second = rng.standard_normal((2, *response.shape))
    amplitude = np.abs(response)
    if Kind(kind) is Kind.AMPLITUDE:
        return np.asarray(np.abs(amplitude + noise.sd(amplitude) * first))
    return np.asarray(response + noise.sd(amplitude) * (first + 1j * second) / np.sqrt(2))
