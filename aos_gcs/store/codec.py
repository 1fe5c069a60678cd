"""Plain JSON data of the mission's frozen dataclasses, and back.

One pair of functions driven by the dataclasses' own annotations, so that a field added to the model is recorded
without a change here. Floats survive exactly (Python writes the shortest text that reads back as the same number);
those that JSON does not know are written as the strings ``nan``, ``inf`` and ``-inf``.
"""

from __future__ import annotations

import functools
import math
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from typing import Any, Final, TypeVar, cast

import numpy as np

T = TypeVar("T")

_ARRAY_TYPES: Final = re.compile(r"[<>|=]?(b1|[iu][1248]|f[248])")
"""NumPy's names of the types that arrays of the mission have."""

Json = None | bool | int | float | str | list["Json"] | dict[str, "Json"]


def encode(value: object) -> Json:  # noqa: PLR0911 (one return per type)
    """Return plain data for ``json.dumps(..., allow_nan=False)``.

    Takes dataclasses, enums, mappings, sequences, NumPy arrays and scalars, nested as they like.

    Raises:
        TypeError: a value has none of these types.
    """
    match value:
        case Enum():
            return cast("Json", value.value)
        case None | bool() | int() | str():
            return value
        case float():
            return float(value) if math.isfinite(value) else repr(float(value))
        case Mapping():
            return {_key(key): encode(item) for key, item in value.items()}
        case list() | tuple():
            return [encode(item) for item in value]
        case np.ndarray():
            return {"dtype": value.dtype.str, "shape": list(value.shape), "values": encode(value.ravel().tolist())}
        case np.generic():
            return encode(value.item())
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: encode(getattr(value, field.name)) for field in fields(value)}
    raise TypeError(f"cannot record a {type(value).__name__}")


def _key(key: object) -> str:
    return str(key.value if isinstance(key, Enum) else key)


def decode(hint: type[T], data: object) -> T:
    """Return the value of type ``hint`` that ``encode`` has made ``data`` from.

    Raises:
        ValueError: the data do not fit the type; the text names the field.
    """
    return cast("T", _decode(hint, data))


def _decode(hint: Any, data: object) -> object:  # noqa: PLR0911 (one return per type)
    origin = typing.get_origin(hint) or hint
    if origin in (typing.Union, types.UnionType):
        return _decode_optional(hint, data)
    if origin in (Any, object):
        return data
    if origin is float:
        return _decode_float(data)
    if origin in (bool, int, str):
        # bool is an int in Python, but true is not a number in JSON
        _require(type(data) is origin, hint, data)
        return data
    if origin is tuple:
        return _decode_tuple(hint, data)
    if origin is np.ndarray:
        return _decode_array(data)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        key_hint, value_hint = typing.get_args(hint)
        return {_decode_key(key_hint, key): _decode(value_hint, item) for key, item in _mapping(hint, data).items()}
    if isinstance(origin, type) and issubclass(origin, Enum):
        return origin(data)
    if is_dataclass(origin):
        return _decode_dataclass(origin, _mapping(hint, data))
    raise ValueError(f"cannot read a {hint}")


def _decode_optional(hint: Any, data: object) -> object:
    members = [member for member in typing.get_args(hint) if member is not type(None)]
    if data is None and len(members) < len(typing.get_args(hint)):
        return None
    if len(members) != 1:
        raise ValueError(f"cannot tell the types of {hint} apart")
    return _decode(members[0], data)


def _decode_float(data: object) -> float:
    is_number = isinstance(data, int | float) and not isinstance(data, bool)
    _require(is_number or data in ("nan", "inf", "-inf"), float, data)
    return float(cast("float", data))


def _decode_tuple(hint: Any, data: object) -> tuple[object, ...]:
    _require(isinstance(data, list), hint, data)
    items, members = cast("list[object]", data), typing.get_args(hint)
    if len(members) == 2 and members[1] is Ellipsis:
        return tuple(_decode(members[0], item) for item in items)
    _require(len(items) == len(members), hint, data)
    return tuple(_decode(member, item) for member, item in zip(members, items, strict=True))


def _decode_array(data: object) -> object:
    parts = _mapping(np.ndarray, data)
    _require({"dtype", "shape", "values"} <= parts.keys(), np.ndarray, data)
    dtype, shape = parts["dtype"], parts["shape"]
    _require(isinstance(dtype, str) and _ARRAY_TYPES.fullmatch(dtype) is not None, np.ndarray, data)
    _require(isinstance(shape, list) and all(type(edge) is int and edge >= 0 for edge in shape), np.ndarray, data)
    try:
        # NumPy reads the strings nan and inf as the numbers they stand for
        return np.array(parts["values"], dtype=dtype).reshape(cast("list[int]", shape))  # type: ignore[call-overload]
    except (TypeError, OverflowError) as error:
        raise ValueError(str(error)) from error


def _decode_key(hint: Any, key: str) -> object:
    return int(key) if hint is int else _decode(hint, key)


def _decode_dataclass(cls: Any, data: Mapping[str, object]) -> object:
    hints = _hints(cls)
    missing = [
        field.name
        for field in fields(cls)
        if field.name not in data and field.default is MISSING and field.default_factory is MISSING
    ]
    if missing or data.keys() - hints.keys():
        names = ", ".join(missing or sorted(data.keys() - hints.keys()))
        raise ValueError(f"{cls.__name__}: {'missing' if missing else 'unknown'} {names}")
    values = {}
    for name, item in data.items():
        try:
            values[name] = _decode(hints[name], item)
        except ValueError as error:
            raise ValueError(f"{cls.__name__}.{name}: {error}") from error
    return cls(**values)


@functools.cache
def _hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def _mapping(hint: Any, data: object) -> Mapping[str, object]:
    _require(isinstance(data, dict), hint, data)
    return cast("Mapping[str, object]", data)


def _require(fits: bool, hint: Any, data: object) -> None:
    if not fits:
        raise ValueError(f"expected {getattr(hint, '__name__', hint)}, found {str(data)[:60]!r}")
