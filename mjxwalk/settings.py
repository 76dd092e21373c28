"""Trees of frozen dataclasses to plain data and back, and one setting of them replaced by its path.

Reading walks the default settings of the experiment, not their annotations, so that each nested
object comes back as the class it was, and every complaint names the path of the setting.
"""

import dataclasses
import types
from collections.abc import Mapping
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import msgspec

from mjxwalk import depth
from mjxwalk.errors import RunError, near

T = TypeVar("T")

# A strategy's settings are the keyword arguments of its factory, kept in a dict of this name.
OPTIONS = "options"

LARGEST = 1e10  # ours: of any number; larger ones leave float32 without digits for the others
MOST = 2**31 - 1  # of anything that is counted; JAX counts in 32 bits


def to_data(settings: object) -> Any:
    """Returns the settings as dicts, lists, strings and numbers."""
    return msgspec.to_builtins(settings)


def from_data(defaults: T, data: object, path: str = "") -> T:
    """Returns settings of the same class as `defaults`, with every value taken from `data`.

    Raises:
      RunError: a setting is unknown, missing, of a wrong type, or refused by its class.
    """
    if not isinstance(data, dict):
        raise RunError(f"{path or 'the experiment'} must be a table of settings, got {data!r}")
    given = cast("dict[str, object]", data)
    names = _field_names(defaults)
    for name in given:
        if name not in names:
            raise RunError(f"unknown setting {_join(path, name)}{near(name, names)}")
    values: dict[str, object] = {}
    for name in names:
        if name not in given:
            raise RunError(f"setting {_join(path, name)} is missing")
        value = getattr(defaults, name)
        if dataclasses.is_dataclass(value):
            values[name] = from_data(value, given[name], _join(path, name))
        else:
            values[name] = _checked(given[name], _annotation(defaults, name), _join(path, name))
    return _rebuild(defaults, values, path)


def override(settings: T, path: str, text: str, *, root: str = "") -> T:
    """Returns the settings with the one at `path` (names joined by dots) read from `text`.

    A name that is no field of a class with `options` is an option: `strategy.sigma`.

    Raises:
      RunError: no such setting, a value of a wrong type, or one that its class refuses.
    """
    name, _, rest = path.partition(".")
    here = _join(root, name)
    names = _field_names(settings)
    if OPTIONS in names and name not in names:
        return _override_option(settings, path, text, root)
    if name not in names:
        raise RunError(f"unknown setting {here}{near(name, names)}")
    value = getattr(settings, name)
    if rest and value is None:
        value = _begun(settings, name)
    if not rest:
        if dataclasses.is_dataclass(value):
            inside = ", ".join(f"{here}.{n}" for n in _field_names(value))
            raise RunError(f"{here} is a group of settings; set one of {inside}")
        return _rebuild(settings, {name: _parse(settings, name, text, here)}, root)
    if name == OPTIONS and isinstance(value, dict):
        return _override_option(settings, rest, text, root)
    if not dataclasses.is_dataclass(value):
        raise RunError(f"{here} is a single setting and has no {rest!r} inside")
    return _rebuild(settings, {name: override(value, rest, text, root=here)}, root)


def _begun(settings: object, name: str) -> object:
    """Returns a group of settings that is null so far with its usual values, None if it is none."""
    for part in get_args(_annotation(settings, name)):
        if dataclasses.is_dataclass(part):
            return cast("Any", part)()
    return None


def _override_option(settings: T, name: str, text: str, root: str) -> T:
    options = cast("Mapping[str, object]", getattr(settings, OPTIONS))
    here = _join(root, name)
    value: object = _loose(text)
    if name in options and options[name] is not None:
        # An option has no annotation: its present value stands for the type.
        value = _checked(value, type(options[name]), here)
    _check_numbers(value, here)
    return _rebuild(settings, {OPTIONS: {**options, name: value}}, root)


def _parse(settings: object, name: str, text: str, path: str) -> object:
    value = _converted(settings, name, text, path)
    _check_numbers(value, path)
    return value


def _converted(settings: object, name: str, text: str, path: str) -> object:
    annotation = _annotation(settings, name)
    try:
        return msgspec.convert(_loose(text), annotation)
    except msgspec.ValidationError:
        pass
    try:
        # Not meant as JSON: a text of digits.
        return msgspec.convert(text, annotation, strict=False)
    except msgspec.ValidationError:
        raise RunError(f"{path} must be {_words(annotation)}, got {text!r}") from None


def _loose(text: str) -> object:
    try:
        value = msgspec.json.decode(text)
        return text if depth.is_deep(value) else value
    except (msgspec.DecodeError, RecursionError):
        pass
    try:
        return float(text)  # as people write it: .5
    except ValueError:
        return text


def _annotation(settings: object, name: str) -> Any:
    return get_type_hints(type(settings))[name]


def _checked(value: object, annotation: Any, path: str) -> object:
    try:
        converted = msgspec.convert(value, annotation)
    except msgspec.ValidationError:
        raise RunError(f"{path} must be {_words(annotation)}, got {value!r}") from None
    _check_numbers(converted, path)
    return converted


def _check_numbers(value: object, path: str) -> None:
    """Raises RunError unless every number in a setting, however deep, is one to compute with."""
    if isinstance(value, Mapping):
        for name, inner in cast("Mapping[object, object]", value).items():
            _check_numbers(inner, _join(path, str(name)))
    elif isinstance(value, list | tuple):
        for inner in cast("list[object]", value):
            _check_numbers(inner, path)
    elif isinstance(value, int) and abs(value) > MOST:
        raise RunError(f"{path} must be a whole number from {-MOST:,} to {MOST:,}")
    elif isinstance(value, float) and not abs(value) <= LARGEST:
        raise RunError(f"{path} must be a number from {-LARGEST:g} to {LARGEST:g}, got {value}")


def _words(annotation: Any) -> str:
    """Returns a type in words."""
    words = {
        float: "a number",
        int: "a whole number",
        bool: "true or false",
        str: "a text",
        type(None): "null",
    }
    if get_origin(annotation) is Literal:
        return f"one of {', '.join(str(value) for value in get_args(annotation))}"
    if get_origin(annotation) in (Union, types.UnionType):
        return " or ".join(_words(part) for part in get_args(annotation))
    if get_origin(annotation) in (tuple, list):
        return 'a list such as ["name"]' if str in get_args(annotation) else "a list such as [1, 2]"
    if get_origin(annotation) in (dict, Mapping):
        return 'a table such as {"name": 1}'
    if dataclasses.is_dataclass(annotation):
        return "a group of settings, each of which is set by its own name"
    return words.get(annotation) or f"a {getattr(annotation, '__name__', annotation)}"


def _rebuild(settings: T, changes: Mapping[str, object], path: str) -> T:
    # dataclasses.replace on an unbound T: the caller has made sure that it is a dataclass.
    try:
        return cast("T", dataclasses.replace(cast("Any", settings), **changes))
    except (ValueError, TypeError) as error:
        where = f"{path}: " if path else ""
        raise RunError(f"{where}{error}") from None


def _field_names(settings: object) -> list[str]:
    return [field.name for field in dataclasses.fields(cast("Any", settings)) if field.init]


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name
