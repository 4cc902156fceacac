"""Natural modes of a rotor at a spin speed, and how they change with it. A free motion is Re(q e^{λt}), λ = σ + iω_d."""
# Shorter than 40 lines: data that the contract of a problem names.

from __future__ import annotations

from dataclasses import dataclass

from ksmea.arrays import Array, ComplexArray


@dataclass(frozen=True, eq=False)
class Mode:
    """One damped mode at one speed."""

    frequency: float  # damped, rad/s
    damping_ratio: float
    whirl: str  # forward, backward, or mixed where nodes differ or move along lines
    shape: ComplexArray  # (n_node, 4): x, y, φ_x, φ_y, scaled to a largest deflection of 1


@dataclass(frozen=True, eq=False)
class Campbell:
    """Natural frequencies over spin speed, each row rising; NaN where a speed has fewer oscillating modes."""

    speed: Array  # (n_speed,) rad/s
    frequency: Array  # (n_speed, n_mode) damped, rad/s
    damping_ratio: Array  # (n_speed, n_mode); below 0: unstable
