"""Universal files, datasets 58 (text) and 58b (binary), read by pyuff: functions over the speed.

A function is called by its response's node and direction, `12:+X`, or by its response entity where that has a name. Read are
functions over the rotational speed (abscissa type 19), and over a frequency (18) where `speed_unit=Hz` says that it is the speed
of rotation. Complex data are vectors; whether their phase leads is for `phase` to say. Time histories are waveforms.
"""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from collections.abc import Sequence
from typing import Any

import numpy as np

from ksmea.errors import SettingError, shortened, visible
from measurements.formats.curve import Curve
from measurements.formats.sheet import Sheet
from measurements.formats.user_answers import Answers
from measurements.run_up_rows import MAX_ROWS, quoted

DATASET = 58
TIME_RESPONSE, AUTO_SPECTRUM, CROSS_SPECTRUM, RESPONSE_FUNCTION, PSD, ESD = 1, 2, 3, 4, 9, 10
OTHERS = {  # functions that hold no vectors of vibration
    AUTO_SPECTRUM: "an auto spectrum",
    CROSS_SPECTRUM: "a cross spectrum",
    RESPONSE_FUNCTION: "a frequency response function",
    PSD: "a power spectral density",
    ESD: "an energy spectral density",
}
OF_TIME, OF_FREQUENCY, OF_SPEED = 17, 18, 19  # what the abscissa is
DIRECTIONS = {1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z", 0: "0"}
MAX_SETS = 1000
MAX_POINTS = 2 * 10**7


Dataset = dict[str, Any]  # as pyuff reads it


def curves_of_datasets(sets: Sequence[tuple[int, Dataset]], answers: Answers) -> list[Curve]:
    """The functions over the speed of a universal file, of its datasets 58 with their numbers."""
    return [_curve(each, number, answers) for number, each in sets]


def waveforms_of_uff(content: bytes, path: str) -> Sheet:
    """The time histories of a universal file and their common time, as columns."""
    sets = datasets(content, path)
    histories = [each for _, each in sets if each["func_type"] == TIME_RESPONSE]
    if not histories:
        raise SettingError(f"{path}: expected time histories, got none; give format=uff for functions over the speed")
    time = histories[0]["x"]
    columns: dict[str, Any] = {"time": time}
    for each in histories:
        if len(each["x"]) != len(time) or not np.allclose(
            each["x"], time, rtol=0, atol=1e-3 * np.ptp(time) / len(time)
        ):
            raise SettingError(f"{path}: expected time histories that were sampled together, got others; cut them")
        name = _name(each)
        if name in columns:
            raise SettingError(f"{path}: expected each response once, got {shortened(name)} twice; remove one")
        columns[name] = np.real(each["data"])
    return Sheet(path, range(1, len(time) + 1), columns)


def datasets(content: bytes, path: str) -> list[tuple[int, Dataset]]:
    """Number and content of each dataset 58. `SettingError` if the file has none, or cannot be read."""
    try:
        import pyuff
    except ImportError as error:
        raise SettingError(
            f"{path}: universal files are read by pyuff, which is not installed; pip install 'ksmea-bench[formats]'"
        ) from error
    if b"    -1" not in content:
        raise SettingError(
            f"{path}: expected a universal file, got none of its lines with -1; name the format of the file"
        )
    found = []
    with _as_file(content) as name:
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                file: Any = pyuff.UFF(name)
                set_types = [int(each) for each in file.get_set_types()]
                if len(set_types) > MAX_SETS:
                    raise SettingError(f"{path}: expected at most {MAX_SETS} datasets, got {len(set_types)}")
                for number, set_type in enumerate(set_types):
                    if set_type == DATASET:
                        found.append((number + 1, _checked(file.read_sets(number), number + 1, path)))
        except SettingError:
            raise
        except (
            Exception
        ) as error:  # pyuff raises plain exceptions with the file's name in them, which is not the user's
            reason = str(error).replace(name, path)
            raise SettingError(
                f"{path}: expected a universal file that can be read, got {quoted(reason)}; export it again"
            ) from error
    if not found:
        others = ", ".join(map(str, sorted(set(set_types)))) or "none"
        raise SettingError(f"{path}: expected a dataset 58, got {others}; export functions")
    return found


@contextlib.contextmanager
def _as_file(content: bytes) -> Any:
    """pyuff reads files by name: the bytes that were checked, in a file of their own."""
    descriptor, name = tempfile.mkstemp(suffix=".uff")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        yield name
    finally:
        os.unlink(name)


def _checked(each: dict[str, Any], number: int, path: str) -> dict[str, Any]:
    """A dataset with as many points as it says."""
    where = f"{path} dataset {number}"
    x, data = np.asarray(each.get("x")), np.asarray(each.get("data"))
    if x.ndim != 1 or data.shape != x.shape or not len(x):
        raise SettingError(f"{where}: expected points, got none; export it again")
    points = int(each["num_pts"])
    if len(x) > MAX_POINTS:
        raise SettingError(f"{where}: expected at most {MAX_POINTS} points, got {len(x)}")
    if points != len(x):
        raise SettingError(f"{where}: expected {points} points, which it says to have, got {len(x)}; export it again")
    return {**each, "x": x, "data": data}


def _curve(each: dict[str, Any], number: int, answers: Answers) -> Curve:
    where = f"{answers.path} dataset {number}"
    function_type, abscissa = int(each["func_type"]), int(each["abscissa_spec_data_type"])
    if function_type == TIME_RESPONSE or abscissa == OF_TIME:
        raise SettingError(f"{where}: expected a function over the speed, got a time history; give format=waveform")
    if function_type in OTHERS:
        raise SettingError(
            f"{where}: expected vectors of vibration over the speed, got {OTHERS[function_type]}; export order tracks"
        )
    if abscissa == OF_FREQUENCY and answers.speed_unit != "Hz":
        raise SettingError(
            f"{where}: expected a function over the speed, got one over a frequency; if that is the speed of"
            " rotation, give speed_unit=Hz"
        )
    if abscissa not in (OF_FREQUENCY, OF_SPEED):
        raise SettingError(f"{where}: expected a function over the speed (abscissa type 19), got type {abscissa}")
    x, data = each["x"], each["data"]
    if len(x) > MAX_ROWS:
        raise SettingError(f"{where}: expected at most {MAX_ROWS} points, got {len(x)}; thin them out")
    unit = str(each["ordinate_axis_units_lab"]).strip()
    of_speed = str(each["abscissa_axis_units_lab"]).strip()
    return Curve(
        _name(each),
        f"dataset {number}",
        list(range(1, len(x) + 1)),
        x,
        np.abs(data),
        phase=np.angle(data, deg=True) if np.iscomplexobj(data) else None,
        speed_unit="" if of_speed == "NONE" else of_speed,
        unit="" if unit == "NONE" else unit,
    )


def _name(each: dict[str, Any]) -> str:
    entity = str(each.get("rsp_ent_name", "")).strip()
    if entity and entity != "NONE":
        return visible(entity)
    return f"{int(each['rsp_node'])}:{DIRECTIONS.get(int(each['rsp_dir']), str(each['rsp_dir']))}"
