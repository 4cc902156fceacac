"""`export measurement --out RUN.csv`: a synthetic measurement as a file for `measurement=file`.

Further arguments are [problem=NAME] [problem.X=…] [measurement.X=…] [seed=N]. Nothing in the file states what it was
made from.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bench.command_line.messages import USER_ERRORS, in_our_words
from bench.command_line.overrides import Choice, parse, with_quoted_files
from bench.commands.folders import with_option
from bench.storage.files import replace_file
from ksmea.api import synthetic_measurement
from ksmea.errors import SettingError, unknown, visible
from ksmea.loaded_problem import load_problem
from measurements.run_up_csv import as_csv

PROBLEM, MEASUREMENT, SEED = "problem", "measurement", "seed"
SYNTHETIC = "synthetic"
STANDARD = "three_disk"  # the problem of an experiment that names none


def export_measurement(words: list[str]) -> int:
    """Write the file, and print what it holds."""
    others, out = with_option(words, "--out", "export measurement")
    if out is None:
        raise SettingError("export measurement: expected where to write it, got nothing; give --out run.csv")
    target = Path(out)
    if target.exists():
        raise SettingError(
            f"export measurement: expected no {target} yet, found one; choose another --out, or remove it"
        )
    if wrong := [word for word in others if "=" not in word]:
        raise SettingError(f"export measurement: expected setting=value, got {wrong[0]}")
    try:
        choices = parse(with_quoted_files(others))
    except USER_ERRORS as error:
        raise in_our_words(error).within("export measurement") from error
    values = {choice.key: _value(choice) for choice in choices}
    name, seed = values.pop(PROBLEM, STANDARD), values.pop(SEED, 0)
    if values.pop(MEASUREMENT, SYNTHETIC) != SYNTHETIC:
        raise SettingError(
            "export measurement: expected measurement=synthetic, which is made, got another; leave it out"
        )
    if not isinstance(seed, int) or seed < 0:
        raise SettingError(f"export measurement: expected a seed of 0 or more, got {seed}")
    settings: dict[str, dict[str, Any]] = {PROBLEM: {}, MEASUREMENT: {}}
    for key, value in values.items():
        group, _, setting = key.partition(".")
        if group not in settings or not setting or "." in setting:
            raise unknown("setting of export measurement:", key, ["problem.NAME", "measurement.NAME", SEED])
        settings[group][setting] = value
    if settings[MEASUREMENT].get("runs"):
        raise SettingError(
            "measurement.runs: expected one run to export, got several; export each with its own weights"
        )
    rotor = load_problem(str(name), **settings[PROBLEM])
    data = synthetic_measurement(rotor, rng=seed, **settings[MEASUREMENT]).measurement
    remark = f"A synthetic measurement of problem={name}. Units: rpm; m; µm zero to peak; degrees of phase lead."
    target.parent.mkdir(parents=True, exist_ok=True)
    replace_file(target, as_csv(data, [visible(remark)]).encode())
    channels = ", ".join(map(str, data.channels))
    print(visible(f"written: {target}: {len(data.speed)} speeds; {channels}"))
    return 0


def _value(choice: Choice) -> Any:
    if len(choice.values) != 1:
        raise SettingError(f"export measurement: expected one value of {choice.key}, got {len(choice.values)}")
    return choice.values[0]
