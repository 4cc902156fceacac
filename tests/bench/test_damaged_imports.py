"""Damaged files of instruments are refused in one line or read right; `damaged_files` says how to try many more.

A reading is right where every channel that is read has only vectors that the healthy file has at that speed, or values that the
slip itself wrote: a number that was changed into another plausible number cannot be known, and touches one row, one probe or (in a
line of units, the time or the keyphasor) what depends on it. So `fine` means that at most the rows of the changed lines differ;
`consistent` that a line which concerns all rows was changed, and all rows changed alike; `relabelled` that two headings changed
places, so that the file says of itself what nothing in it can contradict. Everything else but a refusal in one line is a fault.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import event, given

from damaged_files import (
    FAULTS,
    IS_LONG,
    MOST_SLIPS,
    Outcome,
    cut,
    damaged,
    other_byte,
    other_cell,
    other_line,
    outcome_of,
    recoded,
    swapped,
    truncated,
)  # fmt: skip
from instrument_files import TABLES, waveform
from measurements.file import File

EXAMPLES = {**TABLES, "waveform": waveform}
LENIENT = {"incomplete": "drop"}  # so that a row that is left out does not make the rest refused
MOST_CHANGED = (
    0.34  # of the rows, by slips in single lines: three of 25, each of which two probes may share, and their turns
)
SAME = 1e-6  # relative: what files print
SAME_TRACKED = 3e-3  # of turns at the end of a record, where the spline of the angle ends elsewhere
TOKENS = [
    *(b"abc", b"", b"1e308", b"-1", b"0", b"nan", b"1,5", b"12.5.3", b"999999999", b"1e400", b"--"),
    *(b"\xb5", b"\xff\xfe", b"\x00"),
]
BINARY = ("excel", "mat", "uff58b")
BYTES = (other_byte, other_byte, cut, truncated)
TEXT = (other_byte, cut, truncated, *[other_cell(TOKENS)] * 3, other_line, other_line, swapped, recoded)


def judged(found, healthy, same):
    """Whether what was read of a damaged file is what the healthy one says, row by row, within `same` (relative)."""
    if not np.all(np.isfinite(found.values)) or np.any(np.diff(found.speed) < 0):
        return Outcome("silently wrong", "values that are not finite, or speeds that do not rise")
    known = {channel: index for index, channel in enumerate(healthy.channels)}
    if not set(found.channels) <= set(known):
        return Outcome("silently wrong", f"channels {', '.join(map(str, found.channels))}")
    own = healthy.values[:, [known[channel] for channel in found.channels]]
    distance = np.abs(found.speed[:, None] - healthy.speed)
    nearest = np.argmin(distance, axis=1)
    is_same_speed = distance[np.arange(len(found.speed)), nearest] <= same * found.speed
    is_same = np.abs(found.values - own[nearest]) <= same * np.abs(own[nearest])
    changed = np.mean(~(is_same & is_same_speed[:, None]), axis=0)
    if np.all(changed <= max(MOST_CHANGED, MOST_SLIPS / len(found.speed))):
        return Outcome("fine")
    if len(found.speed) == len(healthy.speed):  # a unit, a name or another line that concerns all rows
        factor = found.values / own
        order = np.polyfit(np.log(healthy.speed), np.log(np.abs(factor)), 1)[0]
        flat = factor * healthy.speed[:, None] ** -np.round(order)
        in_speed = found.speed / healthy.speed
        alike = [
            np.mean(np.abs(part / np.median(part.real, axis=0) - 1) > 1e-3) <= MOST_CHANGED
            for part in (np.abs(flat), in_speed)
        ]
        if all(alike):
            return Outcome("consistent")
    return Outcome("silently wrong", f"{100 * float(np.max(changed)):.0f} % of the rows of a channel differ")


def is_relabelled(content, healthy):
    """Whether a line of headings has the healthy one's cells in another order."""
    before = {tuple(sorted(cells)): cells for cells in map(cells_of, healthy.split(b"\n")) if len(cells) > 2}
    return any(
        cells != before.get(tuple(sorted(cells)), cells) and not any(cell[:1].isdigit() for cell in cells)
        for cells in map(cells_of, content.split(b"\n"))
    )


def cells_of(line):
    separator = next((each for each in (b";", b"\t", b"|", b",") if each in line), b" ")
    return line.strip().split(separator)


def healthy_reading(name, folder):
    """The example, the file in the folder, and what it says."""
    example = EXAMPLES[name]()
    settings = {**example.settings, **LENIENT}
    path = folder / example.name
    path.write_bytes(example.content)
    return dataclasses.replace(example, settings=settings), path, File(path=str(path), **settings).read()


@pytest.mark.parametrize("name", EXAMPLES if IS_LONG else TABLES)
def test_damaged_files_are_refused_or_read_right(name, tmp_path):
    example, path, healthy = healthy_reading(name, tmp_path)
    endings = set()

    @given(damaged(example.content, BYTES if name in BINARY else TEXT))
    def is_refused_or_right(content):
        def read():
            path.write_bytes(content)
            found = judged(
                File(path=str(path), **example.settings).read(), healthy, SAME_TRACKED if name == "waveform" else SAME
            )
            is_other_heading = found.ending == "silently wrong" and is_relabelled(content, example.content)
            return Outcome("relabelled", found.detail) if is_other_heading else found

        outcome = outcome_of(read)
        event(outcome.ending)
        endings.add(outcome.ending)
        assert outcome.ending not in FAULTS, outcome.detail

    is_refused_or_right()
    assert "refused" in endings


def test_what_is_silently_wrong_is_seen(tmp_path):
    """The judge is no rubber stamp: a conjugate, a factor at half of the speeds and a shifted speed are faults."""
    _, _, healthy = healthy_reading("csv_wide", tmp_path)
    half = np.where(np.arange(len(healthy.speed))[:, None] % 2, 2.0, 1.0)
    for values, speed in (
        (healthy.values * half, healthy.speed),
        (np.conj(healthy.values) * half, healthy.speed),
        (healthy.values, healthy.speed * np.linspace(1, 2, len(healthy.speed))),
    ):
        wrong = dataclasses.replace(healthy, values=values, speed=speed)
        assert judged(wrong, healthy, SAME).ending == "silently wrong"
    assert judged(healthy, healthy, SAME).ending == "fine"
