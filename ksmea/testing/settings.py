"""Properties of every plugin: settings that can be read, checked, sent to workers and kept in a plan."""

from __future__ import annotations

import dataclasses
import inspect
import pickle
import typing
from typing import Any

from ksmea.errors import SettingError
from ksmea.settings.settings import own_fields
from ksmea.settings.types import in_words
from ksmea.testing.exam import Case, ExamFailed, require

PLAIN = (bool, int, float, str, type(None), Any, list, tuple, dict)


def settings_are_documented(case: Case) -> None:
    """The plugin and each of its settings say what they are."""
    plugin = type(case.plugin)
    text = plugin.__doc__ or ""
    require(
        text and not text.startswith(f"{plugin.__name__}("),  # the signature that dataclass puts in its place
        f"a docstring of {plugin.__name__}",
        "none",
        "say in one sentence what it is; `help` shows it",
    )
    for field in dataclasses.fields(plugin):
        require(
            field.metadata.get("help", "").strip(),
            f"a help text of the setting {field.name}",
            "none",
            f'write {field.name}: … = ksmea.setting(default, "what it does", unit="…")',
        )


def settings_are_typed(case: Case) -> None:
    """Each setting has a default, and a type that a command line and a plan can hold."""
    plugin = type(case.plugin)
    try:
        hints = typing.get_type_hints(plugin)
    except NameError as error:
        raise ExamFailed(f"expected types that are known, got {error}; import them at the top of its module") from error
    for field in own_fields(plugin):
        hint = hints[field.name]
        require(
            _is_plain(hint),
            f"a type of the setting {field.name} that a plan can hold",
            in_words(hint),
            "give it bool, int, float, str, None, or lists or mappings of these",
        )
        has_default = field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING
        require(has_default, f"a default of the setting {field.name}", "none", f"give it {in_words(hint)}")


def _is_plain(hint: Any) -> bool:
    options = [option for option in typing.get_args(hint) if option is not ...]
    return all(map(_is_plain, options)) if options else hint in PLAIN


def settings_are_checked(case: Case) -> None:
    """A value of a wrong type is refused in one line when the plugin is made."""
    for field in own_fields(type(case.plugin)):
        if "help" not in field.metadata:
            continue  # `settings_are_documented` says so
        do = f"type {field.name} and call super().__post_init__() where the plugin has its own, or use check() instead"
        try:
            dataclasses.replace(case.plugin, **{field.name: object()})
        except SettingError as error:
            require("\n" not in str(error), f"a refusal of {field.name} in one line", repr(str(error)), do)
        except Exception as error:
            raise ExamFailed(
                f"expected a SettingError, got {type(error).__name__} of {field.name}=object(); {do}"
            ) from error
        else:
            raise ExamFailed(f"expected a SettingError, got none of {field.name}=object(); {do}")


def it_is_frozen_and_pickles(case: Case) -> None:
    """The plugin is frozen data, equal to its pickled copy."""
    plugin = type(case.plugin)
    parameters = vars(plugin).get("__dataclass_params__")
    require(
        parameters is not None and parameters.frozen,
        f"a frozen dataclass {plugin.__name__}",
        inspect.getmro(plugin)[1].__name__ + " without @dataclass(frozen=True)",
        "write that above the class",
    )
    try:
        copy = pickle.loads(pickle.dumps(case.plugin))
    except Exception as error:
        raise ExamFailed(
            f"expected a plugin that pickles, got {type(error).__name__}: {error}; define it at the top of a module, and hold"
            " nothing but plain settings"
        ) from error
    require(copy == case.plugin, "a pickled copy that is equal", repr(copy), "compare by its settings alone")


OF_SETTINGS = (settings_are_documented, settings_are_typed, settings_are_checked, it_is_frozen_and_pickles)
