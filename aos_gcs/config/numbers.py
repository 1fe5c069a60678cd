"""Numbers of the configuration: truth values and text are none, though Python and pydantic would convert them."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from pydantic import BaseModel

from aos_gcs.errors import ConfigurationError


def require_numbers(expected: Any, value: object, place: str) -> None:
    """Refuse truth values and text where a type has numbers; all else is left to pydantic.

    Args:
        expected: type of the value: a plain one, a container, a union, a dataclass or a model.
        value: value of the file.
        place: its section and field, for the text.

    Raises:
        ConfigurationError: a value is no number; the text names the field.
    """
    kinds = tuple(_alternatives(expected))
    if isinstance(value, bool | str) and {int, float} & {*kinds} and type(value) not in kinds:
        shown = str(value).lower() if isinstance(value, bool) else f'the text "{value}"'
        raise ConfigurationError(f"{place} must be a number, but is {shown}.")
    for kind in kinds:
        if isinstance(value, Mapping):
            for name, field in _fields(kind).items():
                if name in value:
                    require_numbers(field, value[name], f"{place}.{name}".removeprefix("."))
        elif isinstance(value, list | tuple):
            for index, (item, one) in enumerate(zip(_items(kind, len(value)), value, strict=False)):
                require_numbers(item, one, f"{place}[{index}]")


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
