"""Output transforms: real outputs for a surrogate from the complex response, and back.

Raw amplitudes of a lightly damped rotor are needles that no smooth surrogate follows; their logarithms are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import unknown
from ksmea.measurement.observable import LARGEST_LOG, Observable

TRANSFORMS = ("auto", "none", "complex", "log", "log_phase")


@dataclass(frozen=True)
class Transform:
    """Transform of the response (k, n_speed, n_channel) to real outputs (k, q), and of outputs to data.

    - `amplitude`: |y|; - `complex`: Re y, Im y; - `log`: ln|y|; - `log_phase`: ln|y|, cos φ, sin φ.

    Outputs are ordered part by part, each part (n_speed, n_channel) in C order. `decode` returns what the
    measurement holds: amplitudes (real) for amplitude data, the complex response otherwise.
    """

    name: str
    observable: Observable
    n_speed: int
    n_channel: int

    @property
    def kind(self) -> Observable:
        """Name of `observable` in plugins, for one release."""
        return self.observable

    def encode(self, response: ComplexArray) -> Array:
        parts: list[Array]
        match self.name:
            case "amplitude":
                parts = [np.abs(response)]
            case "complex":
                parts = [response.real, response.imag]
            case "log":
                parts = [np.log(np.abs(response))]
            case _:  # log_phase
                parts = [np.log(np.abs(response)), np.cos(np.angle(response)), np.sin(np.angle(response))]
        return np.concatenate([part.reshape(len(response), -1) for part in parts], axis=1)

    def decode(self, outputs: Array) -> Array | ComplexArray:
        """Outputs (k, q) → predicted data (k, n_speed, n_channel)."""
        parts = self._parts(outputs)
        if self.name == "amplitude":
            return np.asarray(parts[0])
        if self.name == "log":
            return _amplitude(parts[0])
        if self.name == "complex":
            response = parts[0] + 1j * parts[1]
            return self.observable.seen(response)
        amplitude = _amplitude(parts[0])
        if self.observable is Observable.AMPLITUDE:
            return amplitude
        return np.asarray(amplitude * np.exp(1j * np.arctan2(parts[2], parts[1])))

    def spread(self, outputs_sd: Array, predicted: Array | ComplexArray) -> Array:
        """Standard deviation of the predicted data (k, n_speed, n_channel), m.

        `outputs_sd` is the standard deviation of the outputs, (q,) or (k, q).
        """
        parts = self._parts(np.atleast_2d(outputs_sd))
        if self.name == "amplitude":
            return np.broadcast_to(parts[0], predicted.shape)
        if self.name == "complex":
            return np.broadcast_to(np.hypot(parts[0], parts[1]), predicted.shape)
        relative = parts[0]
        if self.name == "log_phase" and self.observable is Observable.COMPLEX:
            relative = np.sqrt(parts[0] ** 2 + parts[1] ** 2 + parts[2] ** 2)
        return np.asarray(relative * np.abs(predicted))

    def _parts(self, outputs: Array) -> Array:
        n_part = {"amplitude": 1, "complex": 2, "log": 1, "log_phase": 3}[self.name]
        return np.moveaxis(outputs.reshape(len(outputs), n_part, self.n_speed, self.n_channel), 1, 0)


def _amplitude(logarithm: Array) -> Array:
    """Exponential, limited so that its square is still a float.

    A surrogate far from its samples may predict anything.
    """
    return np.exp(np.clip(logarithm, -LARGEST_LOG, LARGEST_LOG))


def make_transform(name: str, observable: Observable, *, n_speed: int, n_channel: int) -> Transform:
    """Transform that a setting names.

    'auto' is the logarithm, with the phase if the data are complex. 'none' is the raw amplitudes, or real and imaginary parts.
    'log' of complex data keeps the phase as well, without which it could not be identified.
    """
    if name not in TRANSFORMS:
        raise unknown("transform", name, TRANSFORMS)
    concrete = {
        "auto": "log" if observable is Observable.AMPLITUDE else "log_phase",
        "none": "amplitude" if observable is Observable.AMPLITUDE else "complex",
        "log": "log" if observable is Observable.AMPLITUDE else "log_phase",
    }.get(name, name)
    return Transform(concrete, observable, n_speed, n_channel)
