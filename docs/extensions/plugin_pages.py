"""Settings of all plugins as Markdown, from their fields, docstrings and registry.

`python -m bench help` is made of these, too.

One section for each plugin of this project, named as on the command line; effects have their unknowns, limits and sources.
"""

from __future__ import annotations

import dataclasses
import inspect
import typing
from collections.abc import Iterable, Iterator, Sequence

from docstring_text import as_markdown, cell
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import expected_range, own_fields, part_fields
from ksmea.settings.types import in_words

EFFECT = "effect"
EXAMPLE = "three_disk"  # the problem that limits of effects are shown for
HEAD = ("setting", "default", "takes", "is")


def group_text(group: str) -> str:
    """A section for each plugin of a group, in alphabetical order."""
    return "\n\n".join(plugin_text(group, name) for name in own_plugins(group))


def effects_overview() -> str:
    """One row per effect: unknowns and locations on the example problem, and look-alikes."""
    problem = registry.create("problem", EXAMPLE, {}).build()
    rows = []
    for name in own_plugins(EFFECT):
        effect = registry.create(EFFECT, name, {})
        places = ", ".join(str(place) for place in _locations(effect, problem))
        aliases = ", ".join(f"[{alias}](#{alias})" for alias in effect.aliases)
        rows.append(
            (f"[{name}](#{name})", str(len(_parameters_of_example(effect)) or "–"), cell(places or "–"), aliases)
        )
    return table(("effect", "unknowns", f"locations on {EXAMPLE}", "can look like"), rows)


def _locations(effect: AnyEffect, problem: typing.Any) -> Sequence[AnyEffect]:
    try:
        return effect.locations(problem) if effect.is_offered(problem) else ()
    except Exception:  # an effect that does not fit this problem
        return ()


def own_plugins(group: str) -> list[str]:
    """Names of this project's plugins: who builds the site may have others."""
    return [name for name in registry.registered(group) if registry.origin(group, name).startswith(registry.PROJECT)]


def plugin_text(group: str, name: str) -> str:
    """The section of one plugin: what it is, its sources, its settings."""
    plugin = registry.plugin_class(group, name)
    module = inspect.getdoc(inspect.getmodule(plugin)) or ""
    parts = [f"## {name}", as_markdown(inspect.getdoc(plugin) or ""), as_markdown(module)]
    if group == EFFECT:
        effect = registry.create(EFFECT, name, {})
        parts += [_unknowns(effect), _aliases(effect)]
    parts += [_parts(plugin), _settings(group, plugin)]
    return "\n\n".join(part for part in parts if part)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _settings(group: str, plugin: type) -> str:
    fields = own_fields(plugin)
    if not fields:
        return "It has no settings."
    hints = typing.get_type_hints(plugin)
    return table(HEAD, (row(f"{group}.{field.name}", field, hints[field.name]) for field in fields))


def row(key: str, field: dataclasses.Field[typing.Any], hint: typing.Any) -> Iterator[str]:
    """Key, default, type and meaning of a setting."""
    metadata = field.metadata
    source = f" – {metadata['source']}" if metadata.get("source") else ""
    yield f"`{key}`"
    yield f"`{_default(field)}`"
    yield cell(_takes(metadata, hint))
    yield cell(metadata.get("help", "") + source)


def _takes(metadata: typing.Any, hint: typing.Any) -> str:
    if metadata.get("choices"):
        return ", ".join(f"`{choice}`" for choice in metadata["choices"])
    unit = f" ({metadata['unit']})" if metadata.get("unit") else ""
    return ", ".join(filter(None, (in_words(hint) + unit, expected_range(metadata))))


def _default(field: dataclasses.Field[typing.Any]) -> str:
    """Default as written on the command line."""
    default = field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default
    if default is None:
        return "null"
    return str(default).lower() if isinstance(default, bool) else str(default) or "''"


def _parts(plugin: type) -> str:
    """Parts of a method, chosen with it."""
    rows = [(f"`{field.name}`", cell(field.metadata["help"])) for field in part_fields(plugin)]
    return f"Chosen with it:\n\n{table(('part', 'is'), rows)}" if rows else ""


def _unknowns(effect: AnyEffect) -> str:
    rows = [
        (f"`{each.name}`", *(f"{end / each.si_per_unit:g}" for end in (each.lower, each.upper)), cell(each.unit))
        for each in _parameters_of_example(effect)
    ]
    if not rows:
        return f"Its unknowns depend on its settings; on `problem={EXAMPLE}` it has none by itself."
    return f"Unknowns, with their limits on `problem={EXAMPLE}`:\n\n" + table(("unknown", "from", "to", "unit"), rows)


def _parameters_of_example(effect: AnyEffect) -> Sequence[Parameter]:
    try:
        return effect.parameters(registry.create("problem", EXAMPLE, {}).build())
    except Exception:  # an effect that does not fit this problem
        return ()


def _aliases(effect: AnyEffect) -> str:
    rows = [(f"[{alias}](#{alias})", cell(what)) for alias, what in effect.aliases.items()]
    return "Can look like\n\n" + table(("effect", "and what tells them apart"), rows) if rows else ""
