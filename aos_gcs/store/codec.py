"""Plain JSON data of the mission's frozen dataclasses, and back.

One pair of functions driven by the dataclasses' own annotations, so that a field added to the model is recorded
without a change here. Floats survive exactly (Python writes the shortest text that reads back as the same number);
those that JSON does not know are written as the strings ``nan``, ``inf`` and ``-inf``.
"""

from __future__ import annotations

import functools
import json
import math
import re
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from typing import Any, Final, TypeVar, cast

import numpy as np

T = TypeVar("T")

_ARRAY_TYPES: Final = re.compile(r"[<>|=]?(b1|[iu][1248]|f[248])")
"""NumPy's names of the types that arrays of the mission have."""

Decoder = Callable[[Any], object]
"""Reads a value of one type; raises ValueError where the data do not fit."""

Json = None | bool | int | float | str | list["Json"] | dict[str, "Json"]


def encode(value: object) -> Json:
    """Return plain data for ``json.dumps(..., allow_nan=False)``.

    Takes dataclasses, enums, mappings, sequences, NumPy arrays and scalars, nested as they like.

    Raises:
        TypeError: a value has none of these types.
    """
    return _encoder(cast("Any", type(value)))(value)


def dump(value: object, indent: int | None = None) -> str:
    """Return the JSON text of anything that :func:`encode` takes."""
    separators = (",", ":") if indent is None else None
    return json.dumps(encode(value), allow_nan=False, ensure_ascii=False, indent=indent, separators=separators)


@functools.cache
def _encoder(kind: type) -> Callable[[Any], Json]:  # noqa: PLR0911 (one return per type)
    """Return what makes plain data of a type's values."""
    if issubclass(kind, Enum):
        return _encode_enum
    if issubclass(kind, types.NoneType | bool | int | str):
        return _unchanged
    if issubclass(kind, float):
        return _encode_float
    if issubclass(kind, Mapping):
        return lambda value: {_key(key): encode(item) for key, item in value.items()}
    if issubclass(kind, list | tuple):
        return lambda value: [encode(item) for item in value]
    if issubclass(kind, np.ndarray):
        return _encode_array
    if issubclass(kind, np.generic):
        return lambda value: encode(value.item())
    if is_dataclass(kind):
        names = [field.name for field in fields(kind)]
        return lambda value: {name: encode(getattr(value, name)) for name in names}
    raise TypeError(f"cannot record a {kind.__name__}")


def _encode_enum(value: Enum) -> Json:
    return cast("Json", value.value)


def _encode_float(value: float) -> Json:
    return float(value) if math.isfinite(value) else repr(float(value))


def _encode_array(value: np.ndarray) -> Json:
    return {"dtype": value.dtype.str, "shape": list(value.shape), "values": encode(value.ravel().tolist())}


def _key(key: object) -> str:
    return str(key.value if isinstance(key, Enum) else key)


def decode(hint: type[T], data: object) -> T:
    """Return the value of type ``hint`` that ``encode`` has made ``data`` from.

    Raises:
        ValueError: the data do not fit the type; the text names the field.
    """
    return cast("T", _decoder(cast("Any", hint))(data))


@functools.cache
def _decoder(hint: Any) -> Decoder:  # noqa: PLR0911 (one return per type)
    """Return what reads a type. Made once: asking annotations for every value takes longer than reading them."""
    if isinstance(hint, typing.NewType):
        return _decoder(hint.__supertype__)
    origin = typing.get_origin(hint) or hint
    if origin in (typing.Union, types.UnionType):
        return _optional_decoder(hint)
    if origin in (Any, object):
        return _unchanged
    if origin is float:
        return _decode_float
    if origin in (bool, int, str):
        return functools.partial(_decode_plain, origin)
    if origin is tuple:
        return _tuple_decoder(hint)
    if origin is np.ndarray:
        return _decode_array
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return functools.partial(_decode_mapping, hint)
    if isinstance(origin, type) and issubclass(origin, Enum):
        return origin
    if is_dataclass(origin):
        return functools.partial(_decode_dataclass, origin)
    return functools.partial(_refuse, f"cannot read a {hint}")


def _refuse(text: str, _data: object) -> object:
    raise ValueError(text)


def _unchanged(data: Any) -> Any:
    return data


def _decode_plain(hint: type, data: object) -> object:
    # bool is an int in Python, but true is not a number in JSON
    _require(type(data) is hint, hint, data)
    return data


def _optional_decoder(hint: Any) -> Decoder:
    members = [member for member in typing.get_args(hint) if member is not type(None)]
    if len(members) != 1:
        decode_member: Decoder = functools.partial(_refuse, f"cannot tell the types of {hint} apart")
    else:
        decode_member = _decoder(members[0])
    if len(members) == len(typing.get_args(hint)):
        return decode_member
    return lambda data: None if data is None else decode_member(data)


def _decode_float(data: object) -> float:
    if type(data) is float:
        return data
    is_number = isinstance(data, int) and not isinstance(data, bool)
    _require(is_number or data in ("nan", "inf", "-inf"), float, data)
    return float(cast("float", data))


def _tuple_decoder(hint: Any) -> Decoder:
    members = typing.get_args(hint)
    if len(members) == 2 and members[1] is Ellipsis:
        return functools.partial(_decode_sequence, hint, _decoder(members[0]))
    return functools.partial(_decode_tuple, hint, tuple(_decoder(member) for member in members))


def _decode_sequence(hint: Any, decode_item: Decoder, data: object) -> tuple[object, ...]:
    _require(isinstance(data, list), hint, data)
    return tuple([decode_item(item) for item in cast("list[object]", data)])


def _decode_tuple(hint: Any, decoders: tuple[Decoder, ...], data: object) -> tuple[object, ...]:
    _require(isinstance(data, list) and len(data) == len(decoders), hint, data)
    return tuple(decode_item(item) for decode_item, item in zip(decoders, cast("list[object]", data), strict=True))


def _decode_mapping(hint: Any, data: object) -> dict[object, object]:
    key_hint, value_hint = typing.get_args(hint)
    decode_key: Callable[[str], object] = int if key_hint is int else _decoder(key_hint)
    decode_value = _decoder(value_hint)
    return {decode_key(key): decode_value(item) for key, item in _mapping(hint, data).items()}


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


def _decode_dataclass(cls: Any, data: object) -> object:
    decoders, required = _fields(cls)
    values = _mapping(cls, data)
    if missing := [name for name in required if name not in values]:
        raise ValueError(f"{cls.__name__}: missing {', '.join(missing)}")
    if unknown := values.keys() - decoders.keys():
        raise ValueError(f"{cls.__name__}: unknown {', '.join(sorted(unknown))}")
    arguments = {}
    for name, item in values.items():
        try:
            arguments[name] = decoders[name](item)
        except ValueError as error:
            raise ValueError(f"{cls.__name__}.{name}: {error}") from error
    return cls(**arguments)


@functools.cache
def _fields(cls: Any) -> tuple[dict[str, Decoder], tuple[str, ...]]:
    """Return what reads each field of a dataclass, and the fields that have no default."""
    return (
        {name: _decoder(hint) for name, hint in typing.get_type_hints(cls).items()},
        tuple(one.name for one in fields(cls) if one.default is MISSING and one.default_factory is MISSING),
    )


def _mapping(hint: Any, data: object) -> Mapping[str, object]:
    _require(isinstance(data, dict), hint, data)
    return cast("Mapping[str, object]", data)


def _require(fits: bool, hint: Any, data: object) -> None:
    if not fits:
        raise ValueError(f"expected {getattr(hint, '__name__', hint)}, found {str(data)[:60]!r}")
