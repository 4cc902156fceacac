"""Which folders of results the words of a command mean."""

from __future__ import annotations

from pathlib import Path

from bench.plan.plan import PLAN_FILE
from ksmea.errors import SettingError, unknown


def folders(words: list[str], command: str) -> list[Path]:
    """Folders that NAME (below results/) or DIR means: one experiment's, or one per included experiment."""
    if len(words) != 1:
        there = ", ".join(known_results()) or "none below results/ here"
        raise SettingError(
            f"{command}: expected one name or folder of results, got {len(words) or 'none'}; there are: {there}"
        )
    for folder in (Path("results") / words[0], Path(words[0])):
        found = (
            [folder]
            if (folder / PLAN_FILE).is_file()
            else sorted(path.parent for path in folder.glob(f"*/{PLAN_FILE}"))
        )
        if found:
            return found
    raise unknown("results", words[0], known_results())


def known_results() -> list[str]:
    """Names below results/ of the working directory."""
    return sorted({path.relative_to("results").parts[0] for path in Path("results").glob(f"*/**/{PLAN_FILE}")})


def one_folder(words: list[str], command: str) -> Path:
    """The folder of one experiment that NAME (below results/) or DIR means."""
    first, *others = folders(words, command)
    if others:
        raise SettingError(f"{command}: expected one experiment, got {words[0]} with several; name one, as {first}")
    return first


def with_option(words: list[str], option: str, command: str) -> tuple[list[str], str | None]:
    """The words without an option such as `--out DIR` or `--out=DIR`, and its value.

    None if it is not given.
    """
    others: list[str] = []
    value: str | None = None
    remaining = iter(words)
    for word in remaining:
        name, _, given = word.partition("=")
        if name == option:
            value = given or next(remaining, None)
            if value is None:
                raise SettingError(f"{command}: expected a value after {option}, got nothing")
        elif word.startswith("-"):
            raise unknown(f"option of {command}:", name, [option])
        else:
            others.append(word)
    return others, value
