"""The questions that a file of an instrument leaves open, and the settings that answer them.

What a file states holds; a setting that contradicts it is rejected. What neither states is an error that names the
setting to give: nothing is guessed. docs/own_data.md goes through them.
"""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.errors import SettingError
from ksmea.settings.settings import Settings, setting
from measurements.formats.unit_texts import DETECTORS, SCALED, SPEED_UNITS, UNITS, is_voltage

OWN = "run_up"  # the project's own CSV file, which leaves nothing open
FORMATS = (OWN, "csv", "excel", "mat", "tdms", "uff", "system1", "adre", "waveform")
SENSES = ("lag", "lead", "none")
ROTATIONS = ("ccw", "cw")
KEYPHASOR_EDGES = ("rising", "falling")
VECTORS = ("each", "mean")
WAVEFORM_ALONE = ("revolutions", "sampling", "keyphasor_edge", "constant_speed", "speed_band", "vectors")


@dataclass(frozen=True)
class Answers(Settings):
    """A file and what is said of it next to its content."""

    path: str = setting("", "the file; docs/examples/run_up.csv shows the columns and units of the project's own")
    format: str = setting(
        OWN,
        "what wrote the file: the project's own columns, any table (csv, excel, mat, tdms), a universal file (58, 58b), an export"
        " of System 1 or ADRE, or waveforms with a keyphasor; docs/own_data.md",
        choices=FORMATS,
    )
    probes: list[str] = setting(
        [],
        "where each probe looks, as name@m@direction: its name in the file, m from the left end, and x, y, H, V, degrees from x"
        " towards y, or 45R and 45L from the vertical, such as [1X@0.1@45R]",
    )
    columns: list[str] = setting(
        [],
        "what columns of a table, or variables of a .mat file, hold, as role=column: speed, amplitude, phase, real, imag,"
        " response, sigma, time, status; of several probes amplitude.NAME and so on; channel, position, direction, harmonic of"
        " tables with a row per probe",
    )
    sheet: str = setting("", "the sheet of an Excel file; empty: its only one")
    unit: str | None = setting(
        None,
        "unit of amplitudes, if the file does not state it; for volts the unit of the motion, with scale",
        choices=tuple(UNITS),
    )
    scale: float | None = setting(
        None,
        "what 1 of the file is in that unit, such as 5 of volts from a probe of 200 mV/mil with unit=mil; null: 1",
        above=0,
    )
    amplitude: str | None = setting(
        None, "peak to peak, zero to peak or rms, if the file does not state it", choices=DETECTORS
    )
    phase: str | None = setting(
        None, "whether phases are lags or leads, if the file does not state it; none: omit them", choices=SENSES
    )
    speed_unit: str | None = setting(None, "unit of speeds, if the file does not state it", choices=tuple(SPEED_UNITS))
    rotation: str | None = setting(
        None,
        "sense of rotation, counterclockwise or clockwise, seen as the angles of the probes are: x is to the right and y up;"
        " null: from x to y, which angles from the vertical do not say",
        choices=ROTATIONS,
    )
    harmonics: list[float] = setting(
        [1.0], "multiples of the speed of rotation to read, if the file has several", above=0
    )
    revolutions: int = setting(1, "turns of the shaft that each row of a waveform averages", at_least=1)
    keyphasor_edge: str | None = setting(
        None,
        "edge of the keyphasor's mark that phases of waveforms count from, the same for all records of a machine; null: the"
        " leading edge of a mark of less than a quarter of a turn",
        choices=KEYPHASOR_EDGES,
    )
    constant_speed: float | None = setting(
        None, "speed of the shaft throughout a waveform without a keyphasor; amplitudes alone", unit="rpm", above=0
    )
    speed_band: list[float] = setting(
        [],
        "lowest and highest speed (rpm) between which the vibration itself says the speed of a waveform without a keyphasor: its"
        " strongest component, which must be the 1X; amplitudes alone",
        above=0,
    )
    vectors: str = setting(
        "each",
        "whether windows of a waveform are a row each, or one row of their mean, for a record at a steady speed",
        choices=VECTORS,
    )
    sampling: float | None = setting(None, "sampling rate of waveforms that have no column of time", unit="Hz", above=0)
    repeats: str = setting(
        "refuse",
        "what becomes of a speed that a channel has several times: an error, or the complex mean of its rows",
        choices=("refuse", "average"),
    )
    sweep: str | None = setting(
        None,
        "which part of a record that goes up and down is used; any: all rows, in whatever order they stand",
        choices=("up", "down", "any"),
    )
    slow_roll: float | None = setting(
        None,
        "highest speed of slow roll: the mean vector of each channel up to it is subtracted from the rows above; null: none",
        unit="rpm",
        above=0,
    )

    def __post_init__(self) -> None:
        if isinstance(self.unit, str) and is_voltage(
            self.unit
        ):  # which is like none of the units, though its letter is
            raise SettingError(f"unit: expected a unit of motion, got the voltage {self.unit!r}; {SCALED}")
        super().__post_init__()

    def check_answers(self) -> None:
        """Raise `SettingError` if settings answer questions that this format does not ask."""
        defaults = {name: field.default for name, field in type(self).__dataclass_fields__.items()}
        if self.format == OWN:
            for name in ("unit", "scale", "amplitude", "speed_unit", "rotation", "sheet"):
                if getattr(self, name) != defaults[name]:
                    raise SettingError(
                        f"{name}: expected none with format={OWN}, whose header says its units, got {getattr(self, name)};"
                        " leave it out, or name the format of the file"
                    )
            if self.probes or self.columns or self.harmonics != [1.0] or self.phase not in (None, "none"):
                raise SettingError(
                    f"probes, columns, harmonics, phase: expected none with format={OWN}, whose columns have fixed names, got some; leave"
                    " them out, or name the format of the file (format=csv)"
                )
        for name in WAVEFORM_ALONE:
            if self.format != "waveform" and (given := getattr(self, name)) not in (defaults[name], []):
                raise SettingError(
                    f"{name}: expected none with format={self.format}, which holds no waveforms, got {given}; leave it out"
                )
        if self.speed_band and (len(self.speed_band) != 2 or self.speed_band[0] >= self.speed_band[1]):
            raise SettingError(
                f"speed_band: expected [lowest,highest] in rpm, got {self.speed_band}; such as [600,3000]"
            )
        if self.scale is not None and self.unit is None:
            raise SettingError("scale: expected a unit with it, got none; give unit=mil or another")
        if self.format != "excel" and self.sheet and self.format != "waveform":
            raise SettingError(f"sheet: expected none with format={self.format}, got {self.sheet!r}; leave it out")
        if len(set(self.harmonics)) < len(self.harmonics) or 1 not in self.harmonics:
            raise SettingError(f"harmonics: expected each once and 1 among them, got {self.harmonics}; such as [1,2]")
