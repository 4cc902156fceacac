"""Problems by name or file (`ksmea.load_problem`), with the settings that they were built from.

Arrays are SI (rad/s, m). Values of unknowns go by name, in the units that the unknowns have (`parameters`), as on the
command line; a name that is left out has its published value.
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
from ksmea.studies.rotordynamics import RotordynamicsOptions, rotordynamics
from ksmea.units import DEGREE, MICROMETRE, RPM

YAML = (".yaml", ".yml")
HEAD = ("unknown", "unit", "lower limit", "upper limit", "published")


def load_problem(name: str | Path, **settings: Any) -> LoadedProblem:
    """A registered problem by name, or a rotor or an extended model from a YAML file, with its settings.

    >>> import ksmea
    >>> print(ksmea.load_problem("three_disk", mesh=21, n_speed=27))
    three_disk: 27 speeds; x at 0.1 m, y at 0.1 m
    unknown    unit  lower limit  upper limit  published
        kxx    MN/m           10          100         50
        kyy    MN/m           10          100         70
        cxx  kN s/m         0.01            1        0.5
        cyy  kN s/m         0.01            1        0.7
          u    g mm           50          500        200

    Raises `SettingError` for a name that is not registered, a setting that the problem does not have or a file that
    cannot be used.
    """
    if Path(name).suffix in YAML:
        settings = {"file": str(name), **settings}
        name = _problem_of_file(Path(name))
    made = registry.create("problem", str(name), settings)
    return LoadedProblem(str(name), made, made.build())


@dataclass(frozen=True)
class LoadedProblem:
    """A registered problem with its settings. `problem` is all that an identification sees: it knows no true values.

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
        """(n_speed,) rad/s."""
        return self.problem.speed

    @property
    def channels(self) -> tuple[Channel, ...]:
        return self.problem.channels

    @property
    def reference(self) -> dict[str, float]:
        """Published values by name, in the units of the unknowns; none if nothing is published."""
        units = {item.name: item.si_per_unit for item in self.parameters}
        return {name: value / units[name] for name, value in self.settings.reference().items() if name in units}

    def x(self, values: Mapping[str, SupportsFloat] | None = None) -> Array:
        """A parameter vector (d,), SI, from values by name, as numbers or of an identification; `SettingError` if one has no value.
        The origin of measured phases, which belongs to the data, is passed over."""
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
        """Unbalance response (n_speed, n_channel), complex, m 0-peak, under Re(q e^{iΩt}).

        `speed` (rad/s) and `channels` are the problem's own if they are not given.
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
        """The response at identified values by speed and channel, with its standard deviations: amplitude (µm 0-peak) and phase
        lead (degrees), to first order in the covariance of the values. The noise of a further reading is not part of them.

        `SettingError` if an interval is open or missing.
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
        """Speeds (rad/s) at which a damped natural frequency equals the speed, up to `highest` (the highest of the
        problem's speeds if not given)."""
        return self.problem.critical_speeds(self.x(values), highest)

    def modes(
        self, speed: float, values: Mapping[str, SupportsFloat] | None = None, *, n_mode: int = 6
    ) -> tuple[Mode, ...]:
        """The first damped modes at a speed (rad/s): frequency, damping ratio, whirl and shape."""
        return self.problem.modes(self.x(values), speed, n_mode)

    def campbell(
        self, speed: Array | None = None, values: Mapping[str, SupportsFloat] | None = None, *, n_mode: int = 6
    ) -> Campbell:
        """Natural frequencies and damping ratios over speed (rad/s), by default from rest to the highest speed."""
        if speed is None:
            speed = np.linspace(0.0, float(self.speed.max()), 51)
        return self.problem.campbell(self.x(values), np.asarray(speed, float), n_mode)

    def stability_threshold(
        self, values: Mapping[str, SupportsFloat] | None = None, *, highest: float | None = None
    ) -> float:
        """The lowest spin speed (rad/s) at which a free motion grows, up to `highest` (the highest of the problem's speeds
        if not given); 0: from rest, infinite: nowhere."""
        return self.problem.stability_threshold(self.x(values), float(self.speed.max()) if highest is None else highest)

    @one_blas_thread
    def draw(self, values: Mapping[str, SupportsFloat] | None = None, **options: Any) -> RotorDrawing:
        """Rotor to scale, Campbell diagram, critical speeds, stability, critical speed map and mode shapes.

        `options` are the settings of `python -m bench draw`: highest_rpm, speed_rpm, modes, harmonics … An unknown
        without a value takes the midpoint of its limits, the geometric one if they lie a decade or more apart.

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

        They are in the units of the unknowns, and geometric if the limits lie a decade or more apart.
        """
        known = self.reference | dict.fromkeys(values or {}, 0.0)
        return middles(self.parameters, [each.name for each in self.parameters if each.name not in known])

    def with_settings(self, **settings: Any) -> LoadedProblem:
        """Problem with some of its settings changed."""
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
    """Whether a YAML file describes a rotor or an extended model, by the keys that it begins its lines with."""
    try:
        text = path.expanduser().read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise SettingError(f"{path}: expected a YAML file that can be read, got {type(error).__name__}") from error
    keys = {line.partition(":")[0] for line in text.splitlines() if line[:1].isalpha()}
    return "extended" if {"problem", "effects"} <= keys else "rotor"
