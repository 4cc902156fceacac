"""What damaged files of instruments do to their readers: `python -m benchmarks.fuzz_importers [N] [--only NAME] [--seed 0]`.

Each trial mutates a healthy file (`tests/helpers/instrument_files.py`) one to three times and reads it in a process of its own,
with 20 s and 2 GB. A reading is right where every channel that is read has only vectors that the healthy file has at that speed,
or values that the mutation itself wrote: a number that was changed into another plausible number cannot be known, and touches one
row, one probe or (in a line of units, the time or the keyphasor) what depends on it. So `fine` means that at most the rows of the
mutated lines differ; `consistent` that a line which concerns all rows was changed, and all rows changed alike; `relabelled` that two
headings changed places, so that the file says of itself what nothing in it can contradict. Everything else but a refusal in one
line is a fault.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import io
import os
import random
import sys
import tempfile
import time
import traceback
import unicodedata
from collections import Counter
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # before numpy: trials are forks

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))

from benchmarks.isolated_trial import Outcome, isolated
from instrument_files import TABLES, Example, waveform
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Measurement
from measurements.file import File

EXAMPLES = {**TABLES, "waveform": waveform}
LENIENT = {"incomplete": "drop"}  # so that a row that is left out does not make the rest refused
SECONDS, BYTES = 20, 2 * 2**30
FAULTS = ("traceback", "hang", "memory", "several lines", "silently wrong", "died")
GOOD = ("fine", "consistent", "relabelled", "refused")
MOST_CHANGED = (
    0.34  # of the rows, by mutations of single lines: three of 25, each of which two probes may share, and their turns
)
MOST_MUTATIONS = 3  # of a file, each of which may change a row
SAME = 1e-6  # relative: what files print
SAME_TRACKED = 3e-3  # of turns at the end of a record, where the spline of the angle ends elsewhere
TOKENS = [
    b"abc",
    b"",
    b"1e308",
    b"-1",
    b"0",
    b"nan",
    b"1,5",
    b"12.5.3",
    b"\xb5",
    b"\xff\xfe",
    b"999999999",
    b"1e400",
    b"--",
    b"\x00",
]
BINARY = ("excel", "mat", "uff58b")


def mutated(content: bytes, rng: random.Random, *, binary: bool) -> bytes:
    """A file after one to three slips of a pen, an editor, a spreadsheet or a disk."""
    for _ in range(rng.choice((1, 1, 2, 3))):
        mutations = (_byte, _byte, _cut, _truncated) if binary else TEXT
        content = rng.choice(mutations)(content, rng)
    return content


def _byte(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content) or 1)
    return content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]


def _cut(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content) + 1)
    return content[:at] + content[at + rng.choice((1, 4, 40)) :]


def _truncated(content: bytes, rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _token(content: bytes, rng: random.Random) -> bytes:
    """One cell is something else."""
    lines = content.split(b"\n")
    at = rng.randrange(len(lines))
    separator = next((each for each in (b";", b"\t", b"|", b",") if each in lines[at]), b" ")
    cells = lines[at].split(separator)
    cells[rng.randrange(len(cells))] = rng.choice(TOKENS)
    lines[at] = separator.join(cells)
    return b"\n".join(lines)


def _doubled(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    line = rng.choice(lines)
    lines.insert(rng.randrange(len(lines) + 1), line)
    return b"\n".join(lines)


def _removed(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    del lines[rng.randrange(len(lines))]
    return b"\n".join(lines)


def _swapped(content: bytes, rng: random.Random) -> bytes:
    """Two cells of one line change places."""
    lines = content.split(b"\n")
    at = rng.randrange(len(lines))
    separator = next((each for each in (b";", b"\t", b"|", b",") if each in lines[at]), b" ")
    cells = lines[at].split(separator)
    first, second = rng.randrange(len(cells)), rng.randrange(len(cells))
    cells[first], cells[second] = cells[second], cells[first]
    lines[at] = separator.join(cells)
    return b"\n".join(lines)


def _recoded(content: bytes, rng: random.Random) -> bytes:
    for encoding in ("utf-8", "utf-16", "latin-1"):
        with contextlib.suppress(UnicodeError):
            return content.decode(encoding).encode(
                rng.choice(("utf-16", "utf-8", "latin-1", "utf-32", "cp500")), "replace"
            )
    return content


TEXT = (_byte, _cut, _truncated, _token, _token, _token, _doubled, _removed, _swapped, _recoded)


def judged(found: Measurement, healthy: Measurement, same: float) -> Outcome:
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
    if np.all(changed <= max(MOST_CHANGED, MOST_MUTATIONS / len(found.speed))):
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


def is_relabelled(content: bytes, healthy: bytes) -> bool:
    """Whether a line of headings has the healthy one's cells in another order."""
    before = {tuple(sorted(cells)): cells for cells in map(_cells, healthy.split(b"\n")) if len(cells) > 2}
    return any(
        cells != before.get(tuple(sorted(cells)), cells) and not any(cell[:1].isdigit() for cell in cells)
        for cells in map(_cells, content.split(b"\n"))
    )


def _cells(line: bytes) -> list[bytes]:
    separator = next((each for each in (b";", b"\t", b"|", b",") if each in line), b" ")
    return line.strip().split(separator)


def outcome_of(name: str, content: bytes, example: Example, healthy: Measurement, folder: Path) -> Outcome:
    """What a damaged file does in this process."""
    path = folder / example.name
    path.write_bytes(content)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            found = File(path=str(path), **example.settings).read()
    except SettingError as error:
        told = str(error)
        is_line = all(unicodedata.category(sign) not in ("Cc", "Cf", "Zl", "Zp", "Cs") for sign in told)
        return Outcome("refused", told) if is_line else Outcome("several lines", told)
    except MemoryError:
        return Outcome("memory", traceback.format_exc())
    except Exception:
        return Outcome("traceback", traceback.format_exc())
    return judged(found, healthy, SAME_TRACKED if name == "waveform" else SAME)


def trial(name: str, content: bytes, example: Example, healthy: Measurement, folder: Path) -> Outcome:
    """The same in a process of its own within the limits."""
    return isolated(lambda: outcome_of(name, content, example, healthy, folder), SECONDS, BYTES)


def fuzz(name: str, seeds: range, folder: Path, *, apart: bool = True) -> dict[int, Outcome]:
    """The outcome of each seed's mutation; `apart`: each in a process of its own."""
    example = EXAMPLES[name]()
    example = dataclasses.replace(example, settings={**example.settings, **LENIENT})
    path = folder / example.name
    path.write_bytes(example.content)
    healthy = File(path=str(path), **example.settings).read()
    run = trial if apart else outcome_of
    found = {}
    for seed in seeds:
        content = mutated(example.content, random.Random(f"{name} {seed}"), binary=name in BINARY)
        outcome = run(name, content, example, healthy, folder)
        if outcome.ending == "silently wrong" and is_relabelled(content, example.content):
            outcome = Outcome("relabelled", outcome.detail)
        found[seed] = outcome
    return found


def report(name: str, found: dict[int, Outcome], seconds: float) -> int:
    """Print the counts, and the first of each fault; how many faults there are."""
    counts = Counter(outcome.ending for outcome in found.values())
    told = ", ".join(f"{counts[ending]} {ending}" for ending in (*GOOD, *FAULTS) if counts[ending])
    print(f"{name:9} {len(found):5d} files: {told} ({seconds:.0f} s)", flush=True)
    for fault in FAULTS:
        first = next(((seed, outcome) for seed, outcome in found.items() if outcome.ending == fault), None)
        if first is not None:
            print(f"  first {fault}, seed {first[0]}: {first[1].detail.strip().splitlines()[-1:]}")
    return sum(counts[fault] for fault in FAULTS)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trials", nargs="?", type=int, default=2000)
    parser.add_argument("--only", choices=[*EXAMPLES])
    parser.add_argument("--seed", type=int, default=0, help="of the first trial; the others follow")
    arguments = parser.parse_args()
    n_fault = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in [arguments.only] if arguments.only else EXAMPLES:
            started = time.monotonic()
            found = fuzz(name, range(arguments.seed, arguments.seed + arguments.trials), Path(folder))
            n_fault += report(name, found, time.monotonic() - started)
    return 1 if n_fault else 0


if __name__ == "__main__":
    sys.exit(main())
