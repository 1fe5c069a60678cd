"""Numbers and switches of the configuration: what Python and pydantic would convert to them is none."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from pydantic import BaseModel

from aos_gcs.errors import ConfigurationError


def require_exact(expected: Any, value: object, place: str) -> None:
    """Refuse truth values and text for numbers, anything but true and false for switches, and unknown fields.

    All else is left to pydantic.

    Args:
        expected: type of the value: a plain one, a container, a union, a dataclass or a model.
        value: value of the file.
        place: its section and field, for the text.

    Raises:
        ConfigurationError: a value is none of its field, or there is no such field; the text names it.
    """
    kinds = tuple(_alternatives(expected))
    if isinstance(value, bool | str) and {int, float} & {*kinds} and type(value) not in kinds:
        raise ConfigurationError(f"{place} must be a number, but is {_shown(value)}.")
    if isinstance(value, str | int | float) and bool in kinds and type(value) not in kinds:
        raise ConfigurationError(f"{place} must be true or false, without quotes, but is {_shown(value)}.")
    for kind in kinds:
        if isinstance(value, Mapping) and (fields := _fields(kind)):
            for name, one in value.items():
                inner = f"{place}.{name}".removeprefix(".")
                if name not in fields:
                    raise ConfigurationError(f"{inner} is unknown; known are: {', '.join(fields)}.")
                require_exact(fields[name], one, inner)
        elif isinstance(value, list | tuple):
            for index, (item, one) in enumerate(zip(_items(kind, len(value)), value, strict=False)):
                require_exact(item, one, f"{place}[{index}]")


def _shown(value: object) -> str:
    """Return a value as a file has it, for a message."""
    return str(value).lower() if isinstance(value, bool | int | float) else f'the text "{value}"'


def _alternatives(expected: Any) -> Iterator[Any]:
    """Yield the types that a type allows, without what pydantic adds to them."""
    origin = typing.get_origin(expected)
    if origin is typing.Annotated:
        yield from _alternatives(typing.get_args(expected)[0])
    elif origin in {typing.Union, types.UnionType}:
        for one in typing.get_args(expected):
            yield from _alternatives(one)
    else:
        yield expected


@cache
def _fields(kind: Any) -> Mapping[str, Any]:
    """Return the types of a class's fields; none of other types."""
    is_class = isinstance(kind, type) and (dataclasses.is_dataclass(kind) or issubclass(kind, BaseModel))
    return typing.get_type_hints(kind, include_extras=True) if is_class else {}


def _items(kind: Any, count: int) -> list[Any]:
    """Return the types of so many items of a list or tuple; none of other types."""
    arguments = typing.get_args(kind)
    if typing.get_origin(kind) is list or (typing.get_origin(kind) is tuple and arguments[-1:] == (...,)):
        return [arguments[0]] * count
    return list(arguments) if typing.get_origin(kind) is tuple else []
