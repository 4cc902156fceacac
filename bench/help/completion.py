"""Tab completion: the scripts for bash and zsh, and the candidates that they request at each press.

The shell hands over the words of its line up to the cursor. Candidates come from listings alone: no plugin is imported,
nor any module that needs numpy.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from bench.command_line.bench_settings import bench_fields, default_plugins
from bench.command_line.config_dirs import EXPERIMENT, experiment_files, folders
from bench.command_line.output_level import OPTIONS
from bench.command_line.source_settings import source_settings
from bench.command_line.word_shapes import HYDRA_OPTIONS
from bench.help.commands import command_names
from bench.storage.own_files import REFERENCE
from ksmea.errors import SettingError, unknown
from ksmea.plugins.names import FURTHER, GROUPS, registered

SHELLS = ("bash", "zsh")
ANSWERS = ("--help", "--version")
TEMPLATES = ("effect", "method", "optimizer", "problem", "surrogate")  # which `new` makes
FORMATS = ("coco", "csv", "ioh")  # which `export` writes
FILES = "<files>"  # a line that asks the shell for names of files
PLAN = "plan.jsonl"


def script(words: Sequence[str]) -> str:
    """The script of a shell, to be evaluated in it."""
    if len(words) != 1:
        raise SettingError(
            f"completion: expected {' or '.join(SHELLS)}, got {len(words) or 'nothing'}; as completion bash"
        )
    if words[0] not in SHELLS:
        raise unknown("shell", words[0], SHELLS)
    return Path(__file__).with_name(f"completion.{words[0]}").read_text(encoding="utf-8").rstrip()


def completed(words: Sequence[str]) -> str:
    """Completions of the last word, a line each; `<files>` where it may be the name of a file."""
    *before, current = words or [""]
    try:
        offered = [*_offered(before, current)]
    except (SettingError, OSError):  # what is typed so far is wrong: nothing goes on from there
        offered = []
    return "\n".join(sorted({each for each in offered if each.startswith(current) or each == FILES}))


def _offered(before: Sequence[str], current: str) -> Iterable[str]:
    command = before[0] if before else ""
    if current.startswith("-"):
        return [*OPTIONS, *ANSWERS, *([] if command in _commands() else HYDRA_OPTIONS)]
    if command in _commands():
        return _of_command(command, before[1:])
    key, sign, value = current.partition("=")
    if sign:
        *done, _ = value.split(",")
        start = f"{key}={''.join(f'{each},' for each in done)}"
        found = _values(key.lstrip("+"), before)
        return [each if each == FILES else f"{start}{each}" for each in found if each not in done]
    commands = [] if before else _commands()
    return [*commands, f"+{EXPERIMENT}=", *_settings(before, current)]


def _commands() -> list[str]:
    from bench.help.help import USAGE

    return command_names(USAGE)


def _of_command(command: str, given: Sequence[str]) -> Iterable[str]:
    """Words that may follow a command."""
    if command == "help":
        plugins = (name for group in (*GROUPS, *FURTHER) for name in registered(group))
        if given and given[-1] in (*GROUPS, *FURTHER):
            return registered(given[-1])
        return [*_commands(), *experiment_files(), *GROUPS, *FURTHER, *plugins, *bench_fields()]
    first = {"completion": SHELLS, "new": TEMPLATES, "export": FORMATS, "verify": _references()}
    if command in first:
        if not given:
            return first[command]
        if command != "export":
            return []
    if command == "explain" and not given:
        return []
    return [*_results(), FILES]


def _references() -> list[str]:
    return [path.name.removesuffix(".csv") for path in REFERENCE.glob("*.csv") if not path.name.endswith(".runs.csv")]


def _results() -> list[str]:
    """Names of results below the working directory."""
    return [path.name for path in Path("results").glob("*") if (path / PLAN).is_file() or any(path.glob(f"*/{PLAN}"))]


def _settings(before: Sequence[str], current: str) -> Iterable[str]:
    """Settings that may be given: the bench's own, and the settings of the plugins that the words choose."""
    plus = "+" * (len(current) - len(current.lstrip("+")))
    group, dot, below = current.lstrip("+").partition(".")
    if not dot:
        return [*(f"{plus}{name}=" for name in bench_fields()), *(f"{plus}{name}." for name in GROUPS)]
    if group not in GROUPS:
        return []
    plugin, named, _ = below.partition(".")
    names = [plugin] if named else _chosen(group, before)
    prefix = f"{plus}{group}.{plugin}." if named else f"{plus}{group}."
    own = [f"{prefix}{setting}=" for name in names for setting in source_settings(group, name) or ()]
    return own if named or len(names) < 2 else [*own, *(f"{prefix}{name}." for name in names)]


def _chosen(group: str, before: Sequence[str]) -> list[str]:
    """The plugins of a group that words choose; all of them where an experiment may choose others."""
    for word in reversed(before):
        if word.startswith(f"{group}="):
            return [name for name in word.partition("=")[2].split(",") if name in registered(group)]
    is_other = any(word.lstrip("+").startswith(f"{EXPERIMENT}=") for word in before)
    return [*registered(group)] if is_other else [default_plugins()[group]]


def _values(key: str, before: Sequence[str]) -> Iterable[str]:
    """Values of a setting, as far as they can be listed."""
    if key == EXPERIMENT:
        return experiment_files(folders(before))
    if key in GROUPS:
        return registered(key)
    listed = {"table": registered("report"), "paper": _references()}
    if key in listed:
        return listed[key]
    if key in ("output", "share", "plugins"):
        return [FILES]
    type_name, choices = _of_setting(key, before)
    if choices:
        return choices
    if type_name.startswith("bool"):
        return ("true", "false")
    return [FILES] if key.rpartition(".")[2] in ("path", "file") else []


def _of_setting(key: str, before: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """Type and choices of a setting."""
    group, _, setting = key.partition(".")
    if group not in GROUPS:
        field = bench_fields().get(key)
        return ("", ()) if field is None else (str(field.type), field.metadata.get("choices", ()))
    plugin, _, own = setting.partition(".")
    names = [plugin] if own else _chosen(group, before)
    for name in names:
        found = (source_settings(group, name) or {}).get(own or setting)
        if found is not None:
            return found.type, found.choices
    return "", ()
