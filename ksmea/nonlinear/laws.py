"""Laws of a force on the shaft: as a function of speed, or of the motion of its site.

A law has a few real coefficients c: f = Σ c g(Ω), or f = −K q with K = Σ c K(Ω) and q the motion of the site, or
another function of the orbit (`ksmea.nonlinear.contact`). The force also moves its site:

    q = Q + G f(q),

with Q the motion without the force and G the motion per unit of it. If the force is linear, f = −(1 + K G)⁻¹ K Q.

Sign convention: a real force is Re(f e^{iΩt}); a rotating vector is (1, −i) in (x, y).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import DIRECTIONS
from ksmea.nonlinear.contact import OrbitForce, cubic_spring, rotating_asymmetry, rub, spring_above_an_amplitude
from ksmea.nonlinear.harmonic_balance import Balance, Harmonics
from ksmea.nonlinear.steady_motion import SiteForce, SiteMotion, steady_force
from ksmea.units import GRAM_MILLIMETRE, HERTZ, MICROMETRE

FORWARD = np.array([1, -1j])
AXES = np.stack([np.diag([1.0, 0.0]), np.diag([0.0, 1.0])])
CROSS = np.array([[[0.0, 1.0], [-1.0, 0.0]]])
ISOTROPIC = np.concatenate([np.eye(2)[None], CROSS])

N_THRESHOLD = 12  # amplitudes that a search for a threshold starts from
N_NATURAL, STARTS_BEYOND = (
    40,
    1.5,
)  # natural frequencies of a spring-mass that a search starts from; beyond the band, factor
START_RATIOS = (0.003, 0.03, 0.2)  # damping ratios with each of them

OfSpeed = Callable[[Array], ComplexArray]  # speeds (n_speed,) rad/s → what acts per unit of each coefficient


@dataclass(frozen=True)
class Law(ABC):
    """A law by its key in settings and its name for people.

    `coefficients` have a name, a unit and its size in SI.
    """

    key: str
    name: str
    coefficients: tuple[tuple[str, str, float], ...]

    @property
    def follows_motion(self) -> bool:
        """Whether what acts depends on the motion of its site."""
        return True

    @property
    def has_own_mode(self) -> bool:
        """Whether it depends on the frequency of the motion, with a resonance of its own.

        It does not depend on the spin speed.
        """
        return False

    @property
    def from_zero(self) -> tuple[int, ...]:
        """Indices of the coefficients that have no sign, such as an amplitude up to which nothing acts."""
        return ()

    @property
    def least(self) -> Array:
        """The least values of the coefficients, (n_coefficient,): 0 of those without a sign, else none."""
        return np.where(np.isin(np.arange(len(self.coefficients)), self.from_zero), 0.0, -np.inf)

    def starts(self, speed: Array, amplitude: Array) -> Array | None:
        """Coefficients (n, n_coefficient) whose first, the size of the law, is 1.

        A fit starts from the best of them, at speeds (n_speed,) and amplitudes of the site (n_speed,) m. None: the
        force is linear in all coefficients.
        """
        return None

    def shows(self, coefficients: Array, speed: Array) -> bool:
        """Whether coefficients (n_coefficient,) SI describe this law at speeds (n_speed,), not a simpler one."""
        return True

    @abstractmethod
    def at_motion(self, coefficients: Array, speed: Array, motion: ComplexArray) -> ComplexArray:
        """Force (n, n_speed, 2) N if the site moves by `motion` (n, n_speed, 2) m."""

    @abstractmethod
    def steady(self, coefficients: Array, site: SiteMotion) -> ComplexArray:
        """Force (n, n_speed, 2) N with coefficients (n, n_coefficient) SI, in its steady motion.

        If several steady motions exist, `steady_motion` chooses one. Raises LinAlgError if no steady motion exists."""


@dataclass(frozen=True)
class LawOfSpeed(Law):
    """`terms`: N per unit of each coefficient, (n_coefficient, n_speed, 2); N m where it is a moment."""

    terms: OfSpeed

    @property
    def follows_motion(self) -> bool:
        return False

    def at_motion(self, coefficients: Array, speed: Array, motion: ComplexArray) -> ComplexArray:
        return np.asarray(np.einsum("nc,csk->nsk", coefficients, self.terms(speed)))

    def steady(self, coefficients: Array, site: SiteMotion) -> ComplexArray:
        return self.at_motion(coefficients, site.speed, site.without_force)


class StiffnessLaw(Law):
    """Base of laws f = −K q with a dynamic stiffness K that does not depend on the motion."""

    @abstractmethod
    def stiffness(self, coefficients: Array, speed: Array) -> ComplexArray:
        """K (n, n_speed, 2, 2), N/m."""

    def at_motion(self, coefficients: Array, speed: Array, motion: ComplexArray) -> ComplexArray:
        return np.asarray(-(self.stiffness(coefficients, speed) @ motion[..., None])[..., 0])

    def steady(self, coefficients: Array, site: SiteMotion) -> ComplexArray:
        """Steady-state force f = −(1 + K H)⁻¹ K q of the two directions by Cramer's rule.

        It takes a tenth of the time of a solver that is called for each speed.
        """
        (xx, xy), (yx, yy) = np.moveaxis(self.stiffness(coefficients, site.speed), (-2, -1), (0, 1))
        (h_xx, h_xy), (h_yx, h_yy) = np.moveaxis(site.per_force, (-2, -1), (0, 1))
        x, y = np.moveaxis(site.without_force, -1, 0)
        a, b = 1 + xx * h_xx + xy * h_yx, xx * h_xy + xy * h_yy
        c, d = yx * h_xx + yy * h_yx, 1 + yx * h_xy + yy * h_yy
        of_x, of_y, determinant = xx * x + xy * y, yx * x + yy * y, a * d - b * c
        if not determinant.all():
            raise np.linalg.LinAlgError("a force proportional to the motion leaves no steady motion at a speed")
        return np.asarray(np.stack([b * of_y - d * of_x, c * of_x - a * of_y], axis=-1) / determinant[..., None])


@dataclass(frozen=True)
class LinearLaw(StiffnessLaw):
    """`terms`: stiffness K, N/m, per unit of each coefficient, (n_coefficient, n_speed, 2, 2)."""

    terms: OfSpeed

    def stiffness(self, coefficients: Array, speed: Array) -> ComplexArray:
        return np.asarray(np.einsum("nc,c...->n...", coefficients, self.terms(speed)))


@dataclass(frozen=True)
class SpringMass(StiffnessLaw):
    """A mass on a spring and a damper, alike in x and y: an absorber, a flexible disk or blades.

    With mass m, natural frequency ω₀ and damping ratio ζ (J. P. Den Hartog, Mechanical Vibrations, 1956, section 3.2):

        K = −m Ω² (ω₀² + 2iζ ω₀ Ω) / (ω₀² − Ω² + 2iζ ω₀ Ω).
    """

    @property
    def has_own_mode(self) -> bool:
        return True

    @property
    def from_zero(self) -> tuple[int, ...]:
        return (0, 1, 2)

    def stiffness(self, coefficients: Array, speed: Array) -> ComplexArray:
        mass, natural, ratio = coefficients.T[..., None]  # (n, 1) each
        carried = natural**2 + 2j * ratio * natural * speed
        below = carried - speed**2
        with np.errstate(
            divide="ignore", invalid="ignore"
        ):  # undamped at its own frequency: the response is refused as infinite
            whole = -mass * speed**2 * carried / below
        return np.asarray(np.where(mass == 0, 0.0, whole)[..., None, None] * np.eye(2))

    def shows(self, coefficients: Array, speed: Array) -> bool:
        """Below the band it is a spring to the ground, far above it a mass."""
        return bool(speed.min() <= coefficients[1] <= STARTS_BEYOND * speed.max())

    def starts(self, speed: Array, amplitude: Array) -> Array | None:
        highest = STARTS_BEYOND * speed.max()
        natural = np.geomspace(speed.min(), highest, N_NATURAL)
        grid = np.stack(np.meshgrid(1.0, natural, START_RATIOS, indexing="ij"), axis=-1)
        return np.asarray(grid.reshape(-1, 3))


@dataclass(frozen=True)
class NonlinearLaw(Law):
    """Any function of the motion.

    If it bends resonance curves, the sign of its first coefficient gives the direction: above zero it stiffens."""

    on_orbit: OrbitForce
    bends: bool = True
    turns: bool = False  # depends on the angle of the shaft
    clearance: int | None = None

    @property
    def from_zero(self) -> tuple[int, ...]:
        return () if self.clearance is None else (self.clearance,)

    def starts(self, speed: Array, amplitude: Array) -> Array | None:
        """Several thresholds; what is neither one nor the size is zero at first."""
        if self.clearance is None:
            return None
        tried = np.zeros((N_THRESHOLD, len(self.coefficients)))
        tried[:, 0] = 1.0
        tried[:, self.clearance] = np.quantile(amplitude, np.arange(N_THRESHOLD) / N_THRESHOLD)
        return tried

    @property
    def has_corners(self) -> bool:
        return self.clearance is not None

    def stiffens(self, coefficients: Array) -> Array:
        """1 if it stiffens, −1 if it softens, 0 if it does not bend resonance curves, (n,)."""
        return np.sign(coefficients[:, 0]) * self.bends

    def at_motion(self, coefficients: Array, speed: Array, motion: ComplexArray) -> ComplexArray:
        n, n_speed, m = motion.shape
        rotation, moved = Harmonics(), motion.reshape(-1, 1, m)
        none = np.zeros((n * n_speed, 2 * m))
        balance = Balance(self.on_orbit, np.repeat(coefficients, n_speed, axis=0), rotation, none, none[..., None])
        return rotation.motion(balance.acting(rotation.components(moved))[0]).reshape(motion.shape)

    def steady(self, coefficients: Array, site: SiteMotion) -> ComplexArray:
        force = SiteForce(self.on_orbit, coefficients, self.stiffens(coefficients), has_corners=self.has_corners)
        return steady_force(force, site).harmonics[:, :, 0]


def _rotating(power: int) -> OfSpeed:
    """Vector fixed in the rotor that grows with a power of speed.

    Its parts are at angle 0 and a quarter turn on.
    """
    return lambda speed: np.array([1, 1j])[:, None, None] * speed[:, None] ** power * FORWARD


def _stiffness(matrices: Array, factor: complex, power: int) -> OfSpeed:
    return lambda speed: matrices[:, None] * (factor * speed**power)[:, None, None]


def _pair(name: str, unit: str, size: float) -> tuple[tuple[str, str, float], ...]:
    return tuple((f"{name}_{axis}", unit, size) for axis in DIRECTIONS)


def _one(name: str, unit: str, size: float) -> tuple[tuple[str, str, float], ...]:
    return (name, unit, size), (f"{name}_xy", unit, size)


def _together(*parts: OfSpeed) -> OfSpeed:
    return lambda speed: np.concatenate([part(speed) for part in parts])


def _by_key(*laws: Law) -> MappingProxyType[str, Law]:
    return MappingProxyType({law.key: law for law in laws})


SPRING, OF_SPRING = _pair("k", "MN/m", 1e6), _stiffness(AXES, 1, 0)
DAMPER, OF_DAMPER = _pair("c", "kN s/m", 1e3), _stiffness(AXES, 1j, 1)
MASS, OF_MASS = (("m", "kg", 1.0),), _stiffness(np.eye(2)[None], -1, 2)
STOP = (("k", "MN/m", 1e6), ("δ", "µm", MICROMETRE))

LAWS = _by_key(
    LawOfSpeed("constant", "constant, turning with the shaft", _pair("f", "N", 1.0), _rotating(0)),
    LawOfSpeed("proportional_to_speed", "∝ Ω, turning with the shaft", _pair("f/Ω", "N s/rad", 1.0), _rotating(1)),
    LawOfSpeed("unbalance", "unbalance, ∝ Ω²", _pair("u", "g mm", GRAM_MILLIMETRE), _rotating(2)),
    LinearLaw("spring", "spring", SPRING, OF_SPRING),
    LinearLaw("spring_proportional_to_speed", "spring ∝ Ω", _pair("k/Ω", "kN s/m", 1e3), _stiffness(AXES, 1, 1)),
    LinearLaw("damper", "damper", DAMPER, OF_DAMPER),
    LinearLaw("mass", "mass", MASS, OF_MASS),
    LinearLaw("cross_coupling", "cross-coupling", (("k_xy", "MN/m", 1e6),), _stiffness(CROSS, 1, 0)),
    LinearLaw("spring_and_damper", "spring and damper", (*SPRING, *DAMPER), _together(OF_SPRING, OF_DAMPER)),
    LinearLaw(
        "spring_damper_and_mass",
        "spring, damper and mass",
        (*SPRING, *DAMPER, *MASS),
        _together(OF_SPRING, OF_DAMPER, OF_MASS),
    ),
    SpringMass("spring_mass", "spring-mass", (("m", "kg", 1.0), ("f_0", "Hz", HERTZ), ("ζ", "%", 0.01))),
    LinearLaw(
        "cross_coupled_spring_and_damper",
        "cross-coupled spring and damper",
        (*_one("k", "MN/m", 1e6), *_one("c", "kN s/m", 1e3)),
        _together(_stiffness(ISOTROPIC, 1, 0), _stiffness(ISOTROPIC, 1j, 1)),
    ),
    LinearLaw(
        "seal",
        "seal: spring, damper and cross-coupling ∝ Ω",
        (("k", "MN/m", 1e6), ("c", "kN s/m", 1e3), ("k_xy/Ω", "kN s/m", 1e3)),
        _together(_stiffness(ISOTROPIC[:1], 1, 0), _stiffness(ISOTROPIC[:1], 1j, 1), _stiffness(CROSS, 1, 1)),
    ),
    NonlinearLaw(
        "rotating_asymmetry",
        "asymmetry of the turning shaft",
        _pair("Δk", "MN/m", 1e6),
        rotating_asymmetry,
        bends=False,
        turns=True,
    ),
    NonlinearLaw("cubic_spring", "cubic spring", (("k₃", "MN/mm³", 1e15),), cubic_spring),
    NonlinearLaw(
        "spring_above_an_amplitude", "spring above an amplitude", STOP, spring_above_an_amplitude, clearance=1
    ),
    NonlinearLaw("rub", "rub", (*STOP, ("μ", "", 1.0)), rub, clearance=1),
)

# of a moment: what tilts its site is no channel, so that none of them follows the motion
MOMENT_LAWS = _by_key(
    LawOfSpeed("constant_moment", "constant moment, turning with the shaft", _pair("M", "N m", 1.0), _rotating(0)),
    LawOfSpeed(
        "moment_proportional_to_speed",
        "moment ∝ Ω, turning with the shaft",
        _pair("M/Ω", "N m s/rad", 1.0),
        _rotating(1),
    ),
    LawOfSpeed("skew", "skewed disk, moment ∝ Ω²", _pair("M/Ω²", "kg m²", 1.0), _rotating(2)),
)
