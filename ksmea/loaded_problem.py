"""Problems by name or file (`ksmea.load_problem`), with the settings that they were built from.

Arrays are SI (rad/s, m). Values of unknowns go by name, in the units that the unknowns have (`parameters`), as on the
command line; a name that is left out has its published value.

Longer than 400 lines: each member is documented with units and an example.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np
import pandas as pd

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError, unknown
from ksmea.measurement.channel import Channel
from ksmea.numerics.one_thread import one_blas_thread
from ksmea.plugins import registry
from ksmea.plugins.source import ProblemSettings
from ksmea.problem.counted import Model
from ksmea.problem.parameters import PHASE_ORIGIN, Parameter, Parameters, middles
from ksmea.problem.problem import Problem
from ksmea.results import IdentificationResult
from ksmea.rotor_drawing import RotorDrawing
from ksmea.rotordynamics.whirl import Campbell, Mode
from ksmea.settings.regular_files import require_there
from ksmea.studies.rotordynamics import RotordynamicsOptions, rotordynamics
from ksmea.units import DEGREE, MICROMETRE, RPM

YAML = (".yaml", ".yml")
HEAD = ("unknown", "unit", "lower limit", "upper limit", "published")


def load_problem(name: str | Path, **settings: Any) -> LoadedProblem:
    """Load a registered problem by name, or a rotor or extended model from a YAML file.

    Args:
        name: registered name, such as "three_disk", or path of a YAML file (.yaml, .yml).
        **settings: settings of the problem, such as `mesh=21`.

    Returns:
        Problem with its settings, built and ready to be evaluated.

    Raises:
        SettingError: a name that is not registered, a setting that the problem does not have, or a file that cannot be used.

    >>> import ksmea
    >>> print(ksmea.load_problem("three_disk", mesh=21, n_speed=27))
    three_disk: 27 speeds; x at 0.1 m, y at 0.1 m
    unknown    unit  lower limit  upper limit  published
        kxx    MN/m           10          100         50
        kyy    MN/m           10          100         70
        cxx  kN s/m         0.01            1        0.5
        cyy  kN s/m         0.01            1        0.7
          u    g mm           50          500        200
    """
    if Path(name).suffix in YAML:
        settings = {"file": str(name), **settings}
        name = _problem_of_file(Path(name))
    made = registry.create("problem", str(name), settings)
    return LoadedProblem(str(name), made, made.build())


@dataclass(frozen=True)
class LoadedProblem:
    """Registered problem with its settings.

    Args:
        name: registered name.
        settings: settings that the problem was built from, which also have its published values.
        problem: problem as an identification gets it, without true values.

    >>> import ksmea
    >>> rotor = ksmea.load_problem("three_disk", mesh=13, sensors=[0.1, 0.5])
    >>> rotor.parameters.names
    ('kxx', 'kyy', 'cxx', 'cyy', 'u')
    >>> rotor.response({"kxx": 40.0}).shape  # speeds × channels
    (53, 4)
    """

    name: str
    settings: ProblemSettings
    problem: Problem

    @property
    def parameters(self) -> Parameters:
        """The unknowns: names, units and search limits."""
        return self.problem.parameters

    @property
    def speed(self) -> Array:
        """Spin speeds (n_speed,), rad/s."""
        return self.problem.speed

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Probes, each with its position (m), direction and harmonic."""
        return self.problem.channels

    @property
    def reference(self) -> dict[str, float]:
        """Published values by name, in the units of the unknowns; empty if nothing is published."""
        units = {item.name: item.si_per_unit for item in self.parameters}
        return {name: value / units[name] for name, value in self.settings.reference().items() if name in units}

    def x(self, values: Mapping[str, SupportsFloat] | None = None) -> Array:
        """Parameter vector from values by name.

        Args:
            values: values in the units of the unknowns, or an identification. An unknown without a value has its published one. A
                phase origin, which belongs to the data, is ignored if the problem has none.

        Returns:
            Values (d,), SI, in the order of `parameters`.

        Raises:
            SettingError: a name that is not an unknown of the problem, or an unknown without a value.

        >>> import ksmea
        >>> ksmea.load_problem("three_disk").x({"kxx": 40.0})[:2].tolist()  # MN/m → N/m
        [40000000.0, 70000000.0]
        """
        given = {
            name: float(value)
            for name, value in (values or {}).items()
            if name != PHASE_ORIGIN or name in self.parameters.names
        }
        for name in given:
            if name not in self.parameters.names:
                raise unknown("unknown of the problem:", name, self.parameters.names)
        known = self.reference | given
        missing = [name for name in self.parameters.names if name not in known]
        if missing:
            raise SettingError(
                f"{self.name}: expected a value for {', '.join(missing)}, got none; give values={{{missing[0]!r}: …}}"
            )
        return np.array([known[item.name] * item.si_per_unit for item in self.parameters])

    def response(
        self,
        values: Mapping[str, SupportsFloat] | None = None,
        *,
        speed: Array | None = None,
        channels: Sequence[Channel] | None = None,
    ) -> ComplexArray:
        """Unbalance response of the rotor.

        Args:
            values: values of unknowns, as in `x`.
            speed: spin speeds (n_speed,), rad/s. Default: the problem's own.
            channels: probes. Default: the problem's own.

        Returns:
            Complex response q (n_speed, n_channel), m 0-peak; a real response is Re(q e^{iΩt}).

        Raises:
            SettingError: a value is missing, or the problem cannot be evaluated at other speeds and channels.

        >>> import ksmea
        >>> import numpy as np
        >>> rotor = ksmea.load_problem("three_disk", mesh=13)
        >>> rotor.response(speed=np.array([100.0, 200.0, 300.0])).shape
        (3, 2)
        """
        response: ComplexArray = self._seen(speed, channels).response(self.x(values)[None])[0]
        return response

    def prediction(
        self,
        found: IdentificationResult,
        *,
        speed: Array | None = None,
        channels: Sequence[Channel] | None = None,
    ) -> pd.DataFrame:
        """Response at identified values with its standard deviations, by speed and channel.

        The standard deviations are to first order in the covariance of the values. They do not contain the noise of a further reading.

        Args:
            found: identification with a closed interval for each unknown of the problem.
            speed: spin speeds (n_speed,), rad/s. Default: the problem's own.
            channels: probes. Default: the problem's own.

        Returns:
            One row per speed (rpm) and channel, with amplitude (µm 0-peak), phase lead (degrees) and their standard deviations.

        Raises:
            SettingError: an interval is open or missing.
        """
        names, of_found = self.parameters.names, list(found)
        covariance = found.record.covariance
        if covariance is None or not set(names) <= set(of_found):
            raise SettingError(
                f"prediction: expected an identification with a closed interval of each of {', '.join(names)}, got others;"
                " measure more, or take response(found) for the values alone"
            )
        problem = self._seen(speed, channels)
        own = [of_found.index(name) for name in names]
        of_cube = covariance[np.ix_(own, own)] / np.outer(self.parameters.width, self.parameters.width)
        response, sensitivity = Model(problem).linearise(self.parameters.to_cube(self.x(found)))
        relative = sensitivity / response[..., None]  # of ln amplitude and, imaginary, of the phase
        log_sd, phase_sd = (
            np.sqrt(np.einsum("vci,ij,vcj->vc", part, of_cube, part)) for part in (relative.real, relative.imag)
        )
        amplitude = np.abs(response) / MICROMETRE
        columns = {
            "speed_rpm": problem.speed[:, None] / RPM,
            "channel": np.array([str(channel) for channel in problem.channels], dtype=object),
            "amplitude_um_0pk": amplitude,
            "amplitude_sd_um": amplitude * log_sd,
            "phase_lead_deg": np.angle(response) / DEGREE,
            "phase_sd_deg": phase_sd / DEGREE,
        }
        return pd.DataFrame({name: np.broadcast_to(each, response.shape).ravel() for name, each in columns.items()})

    def _seen(self, speed: Array | None, channels: Sequence[Channel] | None) -> Problem:
        """The problem at other speeds (rad/s) or channels; at its own if not given."""
        if speed is None and channels is None:
            return self.problem
        return self.problem.at(
            self.speed if speed is None else np.asarray(speed, float), tuple(channels or self.channels)
        )

    def critical_speeds(
        self, values: Mapping[str, SupportsFloat] | None = None, *, highest: float | None = None
    ) -> Array:
        """Speeds at which a damped natural frequency equals the spin speed.

        Args:
            values: values of unknowns, as in `x`.
            highest: highest speed, rad/s. Default: the highest of the problem's speeds.

        Returns:
            Rising speeds (n,), rad/s.

        Raises:
            SettingError: a value is missing, or the problem has no natural modes.

        >>> import ksmea
        >>> ksmea.load_problem("three_disk").critical_speeds(highest=500.0).round().tolist()
        [379.0, 398.0]
        """
        return self.problem.critical_speeds(self.x(values), highest)

    def modes(
        self, speed: float, values: Mapping[str, SupportsFloat] | None = None, *, n_mode: int = 6
    ) -> tuple[Mode, ...]:
        """First damped natural modes at a spin speed.

        Args:
            speed: spin speed, rad/s.
            values: values of unknowns, as in `x`.
            n_mode: number of modes.

        Returns:
            Modes with frequency, damping ratio, whirl direction and shape.

        Raises:
            SettingError: a value is missing, or the problem has no natural modes.

        >>> import ksmea
        >>> first = ksmea.load_problem("three_disk").modes(speed=300.0, n_mode=1)[0]
        >>> round(first.frequency), first.whirl
        (380, 'backward')
        """
        return self.problem.modes(self.x(values), speed, n_mode)

    def campbell(
        self, speed: Array | None = None, values: Mapping[str, SupportsFloat] | None = None, *, n_mode: int = 6
    ) -> Campbell:
        """Natural frequencies and damping ratios over spin speed.

        Args:
            speed: spin speeds (n_speed,), rad/s. Default: 51 speeds from rest to the highest of the problem.
            values: values of unknowns, as in `x`.
            n_mode: number of modes.

        Returns:
            Campbell diagram as arrays (n_speed, n_mode).

        Raises:
            SettingError: a value is missing, or the problem has no natural modes.
        """
        if speed is None:
            speed = np.linspace(0.0, float(self.speed.max()), 51)
        return self.problem.campbell(self.x(values), np.asarray(speed, float), n_mode)

    def stability_threshold(
        self, values: Mapping[str, SupportsFloat] | None = None, *, highest: float | None = None
    ) -> float:
        """Lowest spin speed at which the rotor is unstable.

        Args:
            values: values of unknowns, as in `x`.
            highest: highest speed that is checked, rad/s. Default: the highest of the problem's speeds.

        Returns:
            Speed, rad/s; 0 if the rotor is unstable from rest, infinite if it is stable up to `highest`.

        Raises:
            SettingError: a value is missing, or the problem does not know its damped eigenvalues.

        >>> import ksmea
        >>> ksmea.load_problem("three_disk").stability_threshold()
        inf
        """
        return self.problem.stability_threshold(self.x(values), float(self.speed.max()) if highest is None else highest)

    @one_blas_thread
    def draw(self, values: Mapping[str, SupportsFloat] | None = None, **options: Any) -> RotorDrawing:
        """Rotor to scale, Campbell diagram, critical speeds, stability, critical speed map and mode shapes.

        Args:
            values: values of unknowns, as in `x`. An unknown without a value takes the midpoint of its limits (`middles`).
            **options: settings of `python -m bench draw`: highest_rpm, speed_rpm, modes, harmonics …

        Returns:
            Figures, tables and text of the rotor.

        Raises:
            SettingError: a name or option is wrong, or the problem is not made of a rotor.

        >>> import ksmea
        >>> drawing = ksmea.load_problem("three_disk").draw(highest_rpm=12_000)
        >>> drawing.to_frame().query("harmonic == 1")["critical_speed_rpm"].round().tolist()
        [3620.0, 3798.0, 10017.0, 11278.0]
        """
        taken = self.middles(values)
        chosen, x = RotordynamicsOptions(**options), self.x({**taken, **(values or {})})
        remarks = _middles_in_words(taken)
        return RotorDrawing(rotordynamics(self.problem, x, chosen, title=self.name, remarks=remarks))

    def middles(self, values: Mapping[str, SupportsFloat] | None = None) -> dict[str, float]:
        """Midpoints of the limits of the unknowns that have neither a published value nor one of `values`.

        Args:
            values: values of unknowns by name; only the names are used.

        Returns:
            Midpoints by name, in the units of the unknowns; geometric if the limits lie a decade or more apart.
        """
        known = self.reference | dict.fromkeys(values or {}, 0.0)
        return middles(self.parameters, [each.name for each in self.parameters if each.name not in known])

    def with_settings(self, **settings: Any) -> LoadedProblem:
        """Problem with some of its settings changed.

        Args:
            **settings: new values by name.

        Returns:
            Problem built again; all other settings are unchanged.

        Raises:
            SettingError: a value is out of its range.

        >>> import ksmea
        >>> len(ksmea.load_problem("three_disk").with_settings(n_speed=5).speed)
        5
        """
        changed = dataclasses.replace(self.settings, **settings)
        return LoadedProblem(self.name, changed, changed.build())

    def __str__(self) -> str:
        rows = [HEAD, *(self._row(item) for item in self.parameters)]
        widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
        table = ["  ".join(text.rjust(width) for text, width in zip(row, widths)) for row in rows]
        return "\n".join([self._title, *table])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in self._row(item))}</tr>" for item in self.parameters
        )
        head = "".join(f"<th>{text}</th>" for text in HEAD)
        return f"<p>{escape(self._title)}</p><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"

    @property
    def _title(self) -> str:
        channels = ", ".join(map(str, self.channels))
        return f"{self.name}: {len(self.speed)} speeds; {channels}"

    def _row(self, item: Parameter) -> tuple[str, ...]:
        unit = item.si_per_unit
        published = self.reference.get(item.name)
        last = "–" if published is None else f"{published:.4g}"
        return item.name, item.unit, f"{item.lower / unit:.4g}", f"{item.upper / unit:.4g}", last


def _middles_in_words(taken: Mapping[str, float]) -> tuple[str, ...]:
    """Sentence on unknowns without a value and their assumed values."""
    if not taken:
        return ()
    first = next(iter(taken))
    return (
        f"No value is known of {', '.join(taken)}.",
        "Such an unknown is taken at the middle of its limits, the geometric one where they lie a decade or more apart.",
        f"values.{first}=… gives another value on the command line, draw({{{first!r}: …}}) in Python.",
    )


def _problem_of_file(path: Path) -> str:
    """Kind of model in a YAML file, "rotor" or "extended", by the keys at the beginning of its lines."""
    file = require_there(str(path), "YAML")
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise SettingError(f"{path}: expected a YAML file that can be read, got {type(error).__name__}") from error
    keys = {line.partition(":")[0] for line in text.splitlines() if line[:1].isalpha()}
    return "extended" if {"problem", "effects"} <= keys else "rotor"
