"""What damaged files do: mutated rotors, extended problems, run-ups, campaigns, plans and records, and how the program answers
each.

    python -m benchmarks.fuzz_files [rotor extended run_up campaign campaign_runs plan records] [--trials 500] [--seed 0]

A trial is one mutated file in a process of its own, with 25 s and 2 GB. A file may be fine or be refused in one line;
everything else is counted, and the first of each kind is printed with the seed that makes it again (`--only SEED`).
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
import unicodedata
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # before numpy: trials are forks

from unittest.mock import patch

from bench import main as bench_main
from bench.reports import collect
from benchmarks.isolated_trial import Outcome, isolated
from ksmea.errors import SettingError
from ksmea.problem.alignment import aligned
from ksmea.problem.problem import Problem
from measurements.campaign import CampaignFile
from measurements.file import File
from problems.extended_file import ExtendedFile
from problems.rotor_file import RotorFile
from problems.three_disk import ThreeDisk

SECONDS, BYTES = 25, 2 * 2**30
FAULTS = ("traceback", "hang", "memory", "control characters", "several lines", "died")
EXAMPLES = Path(__file__).resolve().parents[1] / "docs" / "examples"
CAMPAIGN, RUNS = "campaign.yaml", "two_runs.csv"
SMALL = "+experiment=table3 optimizer.generations=5 optimizer.population=20 method.max_updates=2 samples=25,30"

# fmt: off
NUMBERS = [
    "0", "-1", "1", "1e308", "1e-308", "1e200", "-0.0", "1e400", "1e-200", "nan", ".inf", "1000", "100000", "1000000000",
    "99999999999999999999", "010", "1:30",
]
WORDS = ["~", "null", "no", "[]", "{}", "''", "<<", "*a", "&a x", "!!int 3", '"\\e[31mred"', '"a\\nb"', "x" * 5000]
TOKENS = [
    *NUMBERS, *WORDS, "[" * 200 + "]" * 200, "<<: {length: 3}", "? [a]", "é", "\x1b[2J", "\x00", "\u202e", "\t", "- ",
]
# fmt: on
DATA: list[Any] = [
    None,
    True,
    0,
    -1,
    1,
    2,
    10**9,
    10**30,
    1.5,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "x",
    "kxx",
    "summary",
    "done",
    "\x1b[2J",
    "a\nb",
    "x" * 5000,
    "../../up",
    [],
    [0],
    [[]],
    ["x", 1],
    {},
    {"name": "x"},
    {"a": {"b": []}},
]  # fmt: skip


def mutated_text(content: bytes, rng: random.Random) -> bytes:
    """A text after one to three slips of a pen, an editor or a disk."""
    for _ in range(rng.choice((1, 1, 2, 3))):
        content = rng.choice(TEXT_MUTATIONS)(content, rng)
    return content


def _other_number(content: bytes, rng: random.Random) -> bytes:
    """One number, or one word after a colon, is another thing."""
    starts = [
        at for at in range(1, len(content)) if content[at - 1 : at] in b" [,{-" and content[at : at + 1].isalnum()
    ]
    if not starts:
        return content
    start = rng.choice(starts)
    end = start
    while end < len(content) and content[end : end + 1] not in (b",", b"}", b"]", b"\n", b":"):
        end += 1
    token = rng.choice(NUMBERS if rng.random() < 0.6 else TOKENS)
    return content[:start] + token.encode() + content[end:]


def _byte(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content) + 1)
    return content[:at] + bytes([rng.randrange(256)]) + content[at + rng.randrange(2) :]


def _insertion(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content) + 1)
    return content[:at] + rng.choice(TOKENS).encode() + content[at:]


def _cut(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content) + 1)
    return content[:at] + content[at + rng.choice((1, 5, 50, 500)) :]


def _lines(content: bytes, rng: random.Random) -> bytes:
    """One line is left out, stands twice or elsewhere."""
    lines = content.splitlines(keepends=True) or [b""]
    line = lines[rng.randrange(len(lines))]
    if rng.random() < 0.5:
        lines.remove(line)
    if rng.random() < 0.7:
        lines.insert(rng.randrange(len(lines) + 1), line)
    return b"".join(lines)


TEXT_MUTATIONS = (_other_number, _other_number, _other_number, _byte, _insertion, _cut, _lines)


def mutated_lines(content: bytes, rng: random.Random) -> bytes:
    """Lines of JSON in which one to three values are others, are missing or are too many; now and then no JSON at all."""
    if rng.random() < 0.2:
        return mutated_text(content, rng)
    lines = content.splitlines()
    for _ in range(rng.choice((1, 1, 2, 3))):
        at = rng.randrange(len(lines))
        if rng.random() < 0.2:  # heads and cells are few, runs are many
            at = 0
        data = json.loads(lines[at])
        _mutate(data, rng)
        lines[at] = json.dumps(data).encode()
    return b"\n".join(lines) + b"\n"


def _mutate(data: Any, rng: random.Random) -> None:
    """Change one place of nested data; shallow ones are as likely as deep ones."""
    while True:
        keys = list(data) if isinstance(data, dict) else list(range(len(data)))
        if not keys:
            return
        key = rng.choice(keys)
        if isinstance(data[key], (dict, list)) and data[key] and rng.random() < 0.7:
            data = data[key]
            continue
        change = rng.random()
        if change < 0.15:
            del data[key]
        elif change < 0.25 and isinstance(data, dict):
            data[rng.choice(["x", "name", "\x1b[2J", "bound"])] = rng.choice(DATA)
        else:
            data[key] = rng.choice(DATA)
        return


def read_problem(settings: RotorFile | ExtendedFile) -> None:
    settings.reference(), settings.fingerprint()
    use_problem(settings.build())


def use_problem(problem: Problem) -> None:
    """All that a program asks of a problem before it identifies it."""
    middle = (problem.parameters.lower + problem.parameters.upper) / 2
    problem.response(middle[None])
    if problem.has_sensitivity:
        problem.sensitivity(middle)


def try_rotor(content: bytes, folder: Path) -> None:
    (folder / "rotor.yaml").write_bytes(content)
    read_problem(RotorFile(file=str(folder / "rotor.yaml")))


def try_extended(content: bytes, folder: Path) -> None:
    (folder / "extended.yaml").write_bytes(content)
    read_problem(ExtendedFile(file=str(folder / "extended.yaml")))


def try_run_up(content: bytes, folder: Path) -> None:
    (folder / "run_up.csv").write_bytes(content)
    File(path=str(folder / "run_up.csv")).read()


def try_campaign(content: bytes, folder: Path) -> None:
    """The YAML file, beside the data that it names."""
    (folder / RUNS).write_bytes((EXAMPLES / RUNS).read_bytes())
    (folder / CAMPAIGN).write_bytes(content)
    use_campaign(folder)


def try_campaign_runs(content: bytes, folder: Path) -> None:
    """The data, beside the YAML file that names them."""
    (folder / RUNS).write_bytes(content)
    (folder / CAMPAIGN).write_bytes((EXAMPLES / CAMPAIGN).read_bytes())
    use_campaign(folder)


def use_campaign(folder: Path) -> None:
    source = CampaignFile(path=str(folder / CAMPAIGN), incomplete="drop")
    source.remarks, source.fingerprint()
    use_problem(aligned(ThreeDisk().build(), source.read()))


def try_results(folder: Path) -> None:
    """The commands on results, of a folder; figures are not drawn, which is most of the time of them."""
    refused: list[str] = []
    exports = [["export", each, "--out", str(folder / each)] for each in ("ioh", "coco", "csv")]
    merge = ["merge", str(folder), "--out", str(folder / "merged")]
    with patch.object(collect, "_png", lambda chart: b""):
        for words in (["status"], ["explain", ""], ["collect"], *exports, merge):
            bench_main.run([*words, str(folder)], refused.append)
    if refused:
        raise SettingError("\n".join(refused[:1]))


def try_plan(content: bytes, folder: Path) -> None:
    (folder / "plan.jsonl").write_bytes(content)
    try_results(folder)


def try_records(content: bytes, folder: Path) -> None:
    next((folder / "records").glob("*.jsonl")).write_bytes(content)
    try_results(folder)


@dataclass(frozen=True)
class Target:
    """A file to damage: the healthy one in a folder, how it is damaged, and what is done with it."""

    file: str
    mutate: Callable[[bytes, random.Random], bytes]
    attempt: Callable[[bytes, Path], None]


TARGETS = {
    "rotor": Target("rotor.yaml", mutated_text, try_rotor),
    "extended": Target("extended.yaml", mutated_text, try_extended),
    "run_up": Target("run_up.csv", mutated_text, try_run_up),
    "campaign": Target(CAMPAIGN, mutated_text, try_campaign),
    "campaign_runs": Target(RUNS, mutated_text, try_campaign_runs),
    "plan": Target("plan.jsonl", mutated_lines, try_plan),
    "records": Target("records/batch-0000.jsonl", mutated_lines, try_records),
}


def healthy(target: str, folder: Path) -> bytes:
    """The healthy file; `folder` holds a small experiment (`SMALL`)."""
    file = Path(TARGETS[target].file)
    example = EXAMPLES / file
    content = (example if example.is_file() else folder / file).read_bytes()
    if file.name == CAMPAIGN:  # what is optional stands in remarks
        content = re.sub(rb"(?m)^( *)# (direction|speeds|own):", rb"\1\2:", content)
    if file.suffix == ".yaml":  # most of an example are remarks, whose mutations say nothing
        content = re.sub(rb"(?m)^ *#.*\n| +#.*$", b"", content)
    return content


def outcome_of(target: str, content: bytes, folder: Path) -> Outcome:
    """What a file does in this process, in a folder that may be changed."""
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            TARGETS[target].attempt(content, folder)
        refusal = ""
    except SettingError as error:
        refusal = str(error)
    except MemoryError:
        return Outcome("memory", traceback.format_exc())
    except Exception:
        return Outcome("traceback", traceback.format_exc())
    shown = printed.getvalue() + refusal
    if bad := [sign for sign in shown if sign != "\n" and unicodedata.category(sign) in ("Cc", "Cf", "Zl", "Zp", "Cs")]:
        return Outcome("control characters", f"{bad[0]!r} in {shown[:2000]!r}")
    if "\n" in refusal:
        return Outcome("several lines", refusal)
    return Outcome("refused", refusal) if refusal else Outcome("fine")


def trial(target: str, content: bytes, folder: Path) -> Outcome:
    """The same in a process of its own within the limits."""
    return isolated(lambda: outcome_of(target, content, folder), SECONDS, BYTES)


def fuzz(target: str, seeds: range, origin: Path, place: Path) -> dict[int, Outcome]:
    """The outcome of each seed's mutation."""
    content = healthy(target, origin)
    found = {}
    for seed in seeds:
        folder = place / f"{target}-{seed}"
        shutil.copytree(origin, folder)
        found[seed] = trial(target, TARGETS[target].mutate(content, random.Random(f"{target} {seed}")), folder)
        shutil.rmtree(folder)
    return found


def report(target: str, found: dict[int, Outcome], seconds: float) -> None:
    counts = Counter(outcome.ending for outcome in found.values())
    told = ", ".join(f"{counts[name]} {name}" for name in ("fine", "refused", *FAULTS) if counts[name])
    print(f"{target:13} {len(found):5d} files: {told} ({seconds:.0f} s)", flush=True)
    for fault in FAULTS:
        first = next(((seed, outcome) for seed, outcome in found.items() if outcome.ending == fault), None)
        if first is not None:
            last_words = first[1].detail.strip().splitlines()[-6:]
            print(f"  first {fault}, --only {first[0]}:", *(f"    {line[:200]!r}" for line in last_words), sep="\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", help=f"of {', '.join(TARGETS)}; left out: all")
    parser.add_argument("--trials", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0, help="of the first trial; the others follow")
    parser.add_argument("--only", type=int, help="one trial of this seed")
    arguments = parser.parse_args()
    first, number = (arguments.seed, arguments.trials) if arguments.only is None else (arguments.only, 1)
    n_fault = 0
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        origin = place / "healthy"
        words = [*SMALL.split(), "repetitions=2", f"output={origin}"]
        subprocess.run([sys.executable, "-m", "bench", *words], check=True, stdout=subprocess.DEVNULL)
        for target in arguments.kinds or TARGETS:
            started = time.monotonic()
            found = fuzz(target, range(first, first + number), origin, place)
            report(target, found, time.monotonic() - started)
            n_fault += sum(outcome.ending in FAULTS for outcome in found.values())
    return 1 if n_fault else 0


if __name__ == "__main__":
    sys.exit(main())
