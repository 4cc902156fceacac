"""Measured data from a CSV file: `measurement=file measurement.path=run.csv`.

One row per speed and channel:

    speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,sigma_um
    1500,0.1,x,12.4,-31.5,
    1500,0.1,y,11.9,-122.0,

- `speed_rpm` of the shaft, above 0. Speeds may be unevenly spaced and in any order: a run-up's rows stand in the order
  of time. They are sorted for the analysis; each speed has every channel once.
- `position_m` of the probe from the rotor's left end, `direction` x or y as in the model, or degrees from x towards y, the
  sense in which the shaft turns: 45, -135.
- `amplitude_um_0pk` of the 1X vibration, µm zero to peak: half of peak to peak.
- `phase_lead_deg`, the angle of the complex amplitude q under Re(q e^{iΩt}): on every row (complex data) or on none
  (amplitudes). Instruments often show a lag: that is its negative. The phase origin does not matter.
- `sigma_um`, the standard deviation of the noise of this row: of the amplitude, and for complex data the total one,
  √2 times the one of the real and of the imaginary part. On every row or on none: then the noise is estimated.
- `time_s`, optional: says how fast the speed went, which a diagnosis takes for the rate of a sweep.
- `harmonic`, optional: at which multiple of the speed of rotation the row was measured, 2 for 2X, 0.5 for ½X; empty: 1. Its phase
  is the angle of q under Re(q e^{ihΩt}). Amplitudes alone are taken at 1X alone.
- `run`, the name of a run, where `measurement=campaign` reads a file with several.

The last columns may be missing. Lines that begin with # are remarks, empty lines are left out. Nothing is guessed:
what does not fit is an error that names the line. docs/examples/run_up.csv is such a file.

Files of instruments and tables of other layouts are read by `measurement.format` and settings for what they do not
state (`measurements/formats`, docs/own_data.md). `python -m bench import` writes what it read as the file above.
"""

from __future__ import annotations

import dataclasses
import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.notation import Notation
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.settings.settings import setting
from measurements.common_speeds import averaged
from measurements.formats.lazy_file import Opened
from measurements.formats.readers import foreign_rows
from measurements.formats.user_answers import OWN, Answers
from measurements.formats.waveforms.waveform import MOST_BYTES
from measurements.run_up import RunUp, run_up
from measurements.run_up_rows import MAX_BYTES, Rows, notation_of, rows_at, rows_of, text_of, to_digits
from measurements.shared_speeds import at_shared_speeds
from measurements.slow_roll import SUBTRACTED, without_slow_roll
from measurements.sweeps import ANY, require_one_way, rows_of_sweep

AMPLITUDES_ALONE = (
    "amplitudes alone: phases would add a second number to each, the angle of the unbalance from the mark, harmonics, subtraction of slow"
    " roll, differences between runs, unknown weights and balancing in several planes"
)
HAS_NO_SLOW_ROLL = re.compile(rf"^\s*#\s*{SUBTRACTED}", re.MULTILINE)


@dataclass(frozen=True)
class File(Answers, MeasurementSource):
    """A measured run-up, coast-down or set of steady speeds from a file, amplitudes with or without phase.

    If phases were measured, the unbalance's angle is one more unknown: the origin of measured phases is arbitrary.
    """

    incomplete: str = setting(
        "refuse",
        "what becomes of a speed that lacks a channel: an error, the speed is left out, or channels with speeds of their own are"
        " interpolated to common ones",
        choices=("refuse", "drop", "interpolate"),
    )
    speed_from: float | None = setting(None, "lowest speed of the file that is used; null: all", unit="rpm", above=0)
    speed_to: float | None = setting(None, "highest speed of the file that is used; null: all", unit="rpm", above=0)

    def check(self) -> None:
        if not self.path:
            raise SettingError(
                "path: expected the CSV file of a measurement, got none; give measurement.path=run.csv,"
                " for example docs/examples/run_up.csv"
            )
        if self.speed_from is not None and self.speed_to is not None and self.speed_from >= self.speed_to:
            raise SettingError(
                f"speed_to: expected more than speed_from ({self.speed_from:g}), got {self.speed_to:g}; swap them"
            )
        self.check_answers()
        if self._read_rows[0].run is not None:
            raise SettingError(
                f"{self.path}: expected the rows of one run, got a column run; describe the runs in a YAML file and give"
                " measurement=campaign measurement.path=campaign.yaml"
            )
        self._run_up  # noqa: B018 – reading is checking

    @property
    def kind(self) -> str:
        return "complex" if np.iscomplexobj(self._run_up.values) else "amplitude"

    @property
    def noise(self) -> Noise | None:
        """The noise as the file states it, datum by datum; None if it does not."""
        return None if self._run_up.sigma is None else Noise(0.0, self._run_up.sigma)

    @property
    def noise_known(self) -> bool:
        return self._run_up.sigma is not None

    @property
    def time(self) -> Array | None:
        """When each speed was passed, (n_speed,) s, speeds rising; None if the file does not say."""
        return self._run_up.time

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on what was decided about the file and left out of it."""
        alone = () if self.kind == "complex" else (AMPLITUDES_ALONE,)
        return (*self._prepared[1], *self._run_up.remarks, *alone)

    @property
    def notation(self) -> Notation:
        """Units, detection, sign of phases and names of probes of the file."""
        return self._read_rows[3]

    @property
    def used_rows(self) -> Rows:
        """The rows that make the measurement, in the order of the file."""
        return rows_at(self._prepared[0], sorted(self._run_up.order.reshape(-1).tolist()))

    def fingerprint(self) -> str:
        """Hash of the file's content, which the settings name but do not hold.

        A changed file is another measurement.
        """
        return hashlib.sha256(self._bytes).hexdigest()[:16]

    def layout(self, settings: ProblemSettings) -> Layout:
        """Speeds and channels of the file; if it has phases, their origin is not known."""
        run_up = self._run_up
        lines = tuple(f"{self.path} line {line}" for line in run_up.first_lines)
        return Layout(run_up.speed, run_up.channels, self.kind, self.path, phase_known=False, locations=lines)

    def read(self) -> Measurement:
        """The measurement in the file."""
        run_up, name = self._run_up, Path(self.path).name
        return Measurement(
            run_up.speed,
            run_up.channels,
            run_up.values,
            self.noise,
            name,
            phase_known=False,
            history=run_up.history,
            notation=self.notation,
        )

    @classmethod
    def of(cls, opened: Opened, settings: Mapping[str, Any]) -> Self:
        """A file that is open already, with these settings: what was read of it before is not read again.

        It may have one speed, as a run of a campaign may.
        """
        made = cls.__new__(cls)
        made.__dict__.update(_opened=opened, _least=1)
        cls.__init__(made, path=opened.path, **settings)  # which reads it
        return made

    @cached_property
    def _opened(self) -> Opened:
        return Opened(self.path)

    @property
    def _bytes(self) -> bytes:
        return self._opened.content(MOST_BYTES if self.format == "waveform" else MAX_BYTES)

    @cached_property
    def _read_rows(self) -> tuple[Rows, tuple[str, ...], bool, Notation]:
        """Rows as they stand in the file, remarks on them, whether slow roll is subtracted, and notation."""
        if self.format != OWN:
            return foreign_rows(self._opened, self)
        text = text_of(self._bytes, self.path)
        rows = rows_of(text, self.path)
        if self.phase == "none":
            rows = dataclasses.replace(rows, phase=None)
        return rows, (), bool(HAS_NO_SLOW_ROLL.search(text)), notation_of(text, self.path)

    @cached_property
    def _prepared(self) -> tuple[Rows, tuple[str, ...]]:
        """Rows after all steps that the settings request, and the remarks on these steps.

        The steps follow one another.
        """
        rows, read_remarks, is_compensated, _ = self._read_rows
        remarks: list[str | None] = [*read_remarks]
        if self.sweep not in (None, ANY):
            rows, remark = rows_of_sweep(rows, str(self.sweep), self.path)
            remarks.append(remark)
        elif self.sweep is None and self.format != OWN:
            require_one_way(rows, self.path)
        if self.slow_roll is not None:
            if is_compensated:
                raise SettingError(
                    f"slow_roll: expected a file with slow roll in it, got {self.path}, from which it is subtracted; leave it out"
                )
            rows, remark = without_slow_roll(rows, self.slow_roll, self.path)
            remarks.append(remark)
        elif is_compensated:
            remarks.append(f"{SUBTRACTED}, as the file says")
        if self.repeats == "average":
            rows, averaging = averaged(to_digits(rows))  # as equal as they will be when they are told apart
            remarks.append(averaging)
        if self.incomplete == "interpolate":
            rows, interpolation = at_shared_speeds(rows, self.path)
            remarks.append(interpolation)
        return rows if self.format == OWN else to_digits(rows), tuple(remark for remark in remarks if remark)

    @cached_property
    def _run_up(self) -> RunUp:
        drop = self.incomplete == "drop"
        return run_up(self._prepared[0], self.path, self.speed_from, self.speed_to, drop, self._least)

    @cached_property
    def _least(self) -> int:
        """How many speeds there are at least."""
        return 2
