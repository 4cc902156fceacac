"""Hydra's and OmegaConf's errors in the bench's form: what was expected, what came, what to try."""

from __future__ import annotations

import re
import traceback
from collections.abc import Iterable

from hydra.errors import HydraException, MissingConfigException, OverrideParseException
from omegaconf import Container, OmegaConf
from omegaconf.errors import (
    ConfigAttributeError,
    ConfigKeyError,
    GrammarParseError,
    InterpolationResolutionError,
    OmegaConfBaseException,
    ValidationError,
)

from bench.command_line.corrected_command import in_brackets
from bench.command_line.plugin_settings import unknown_key
from ksmea.errors import SettingError, shortened, unknown
from ksmea.plugins.files import OURS
from ksmea.plugins.registry import GROUPS

USER_ERRORS = (HydraException, OmegaConfBaseException)
LIBRARIES = ("hydra", "omegaconf", "yaml", "antlr4")
FULL_KEY = re.compile(r"^ *full_key: (\S+)$", re.MULTILINE)
COMPOSING = re.compile(r"^In '[^']*': (\w+ raised while composing config:)?\s*")
LONGEST = 200  # characters of a library's own words

EXPECTED = {
    "Integer": "a whole number",
    "Float": "a number",
    "Boolean": "true or false",
    "String": "a text",
}


def in_our_words(error: BaseException) -> SettingError:
    """The innermost thing that Hydra or OmegaConf has to say, in words of the bench."""
    for cause in _causes(error):
        if isinstance(cause, MissingConfigException) and cause.options is not None:
            group, _, name = (cause.missing_cfg_file or "").rpartition("/")
            return unknown(group or "configuration", name, cause.options)
        if isinstance(cause, OverrideParseException):
            key = str(cause.override).partition("=")[0]
            return SettingError(
                f"{cause.override}: expected setting=value, for lists setting=a,b; check quotes and brackets, and put a name"
                f""" with special characters into two pairs of quotes: {key}='"a=(b).csv"'"""
            )
        if isinstance(cause, InterpolationResolutionError):
            return _leads_nowhere(error, str(cause))
        if isinstance(cause, GrammarParseError):
            return SettingError("expected ${setting} with both brackets, got one that is not closed; close it")
        if isinstance(cause, ValidationError) and cause.full_key:
            return _wrong_type(cause)
        if isinstance(cause, (ConfigAttributeError, ConfigKeyError)):
            return _unknown_setting(cause)
    text = COMPOSING.sub("", str(error))
    if found := re.search(r"Could not override '([^']+)'", text):  # a group, or a path below one, that does not exist
        return unknown_key(found[1], GROUPS)
    return SettingError(
        shortened(text, LONGEST)
        if isinstance(error, USER_ERRORS)
        else f"expected settings that Hydra takes, got {_said_by(error)}"
    )


def arose_in_hydra(error: BaseException) -> bool:
    """Whether an error arose inside the libraries that compose a configuration.

    It did not arise in this project or a plugin.
    """
    modules = [frame.f_globals.get("__name__", "") for frame, _ in traceback.walk_tb(error.__traceback__)]
    tops = [module.partition(".")[0] for module in modules]
    return next((top for top in reversed(tops) if top in (*LIBRARIES, *OURS, "hydra_plugins")), "") in LIBRARIES


def _said_by(error: BaseException) -> str:
    return shortened(f"{type(error).__name__}: {error}", LONGEST)


def _leads_nowhere(error: BaseException, said: str) -> SettingError:
    """The error of a ${…} without a value; the outer ones of its chain know the setting."""
    keys = [found[1] for each in _causes(error) if (found := FULL_KEY.search(str(each)))]
    return SettingError(
        "expected ${…} that leads to a setting or a variable (${oc.env:NAME}), got one that does not:"
        f" {shortened(said.splitlines()[0], LONGEST)}",
        setting=keys[0] if keys else "",
    )


def _causes(error: BaseException) -> Iterable[BaseException]:
    """The chain of errors, innermost first."""
    chain = [error]
    while (cause := chain[-1].__cause__ or chain[-1].__context__) is not None and cause not in chain:
        chain.append(cause)
    return reversed(chain)


def _wrong_type(error: ValidationError) -> SettingError:
    """The error of a value of a wrong type, which OmegaConf's sentence alone tells."""
    text, key, meant = str(error.msg), str(error.full_key), None
    if found := re.search(r"Value '(.*)' of type '\w+' could not be converted to (\w+)", text):
        wrong = f"expected {EXPECTED.get(found[2], found[2])}, got '{found[1]}'"
    elif found := re.search(r"Value '(.*)' is not a valid bool", text):
        wrong = f"expected {EXPECTED['Boolean']}, got '{found[1]}'"
    elif "is not Optional" in text:
        wrong = "expected a value, got null"
    elif "is not a ListConfig" in text:
        wrong, meant = "expected a list [a,b,...], got one value", in_brackets
    elif "Cannot assign int to DictConfig" in text or "is not a DictConfig" in text:
        wrong = "expected {name: value, ...}, got one value"
    else:
        wrong = " ".join(text.splitlines()[0].split())
    return SettingError(wrong, setting=key, meant=meant)


def _unknown_setting(error: ConfigAttributeError | ConfigKeyError) -> SettingError:
    key = str(error.full_key or error.key)
    parent = error.parent_node
    names = [str(name) for name in parent] if isinstance(parent, Container) and OmegaConf.is_dict(parent) else []
    return unknown_key(key, [name for name in names if name not in ("name", "hydra")])
