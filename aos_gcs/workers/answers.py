"""Answers of workers: data, of which no bytes make the reader run code, take memory without limit, or stand still.

A worker handles what comes from outside, so what it answers is not believed. The head of an answer is JSON of a closed
set of values; arrays and bytes are in the shared memory, by their types and shapes. Dataclasses and enums are those
that the reader has loaded from the program's own packages, by name; they are filled in, their methods are not called. A
list of classes that may be unpickled would not do: a pickle can set attributes of these classes themselves, and NumPy's
type descriptions, which every array needs, can be forged so that bytes are taken for objects.

Requests go the other way, from the service to its own worker, and are pickled.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import AosError, WorkerError
from aos_gcs.workers.arena import Arena, layout

MAX_HEAD_BYTES: Final = 4 * 2**20
"""Parsing that many takes less than a tenth of a second."""
_PACKAGES: Final = ("aos_gcs.", "aos_drivers.")
_ARRAY_TYPES: Final = re.compile(r"[<>|=](b1|[iu][1248]|f[248]|c(8|16))")
_BUILTIN_ERRORS: Final[dict[str, type[Exception]]] = {
    kind.__name__: kind
    for kind in (
        MemoryError,
        ZeroDivisionError,
        OverflowError,
        ArithmeticError,
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        AssertionError,
        NotImplementedError,
        RuntimeError,
        ValueError,
    )
}
_NOTES: Final = "__notes__"


class MalformedAnswerError(WorkerError):
    """Bytes that are no answer: the worker has a defect, or somebody else uses it."""


def pack_result(result: object, arena: Arena) -> bytes:
    """Return the answer of a function that has returned.

    Raises:
        TypeError: the result has something in it that cannot be answered.
    """
    return _packed("result", result, arena)


def pack_error(error: Exception, arena: Arena) -> bytes:
    """Return the answer of a function that has raised; an error of no known kind goes as the nearest that is."""
    notes = [str(note) for note in getattr(error, _NOTES, ())]
    if isinstance(error, AosError):
        state = {name: value for name, value in vars(error).items() if not name.startswith("_")}
        try:
            return _packed("error", (_name(type(error)), error.args, state, notes), arena)
        except TypeError:
            return _packed("error", ("RuntimeError", (f"{type(error).__name__}: {error}",), {}, notes), arena)
    kind = next((one.__name__ for one in type(error).__mro__ if one.__name__ in _BUILTIN_ERRORS), "RuntimeError")
    text = str(error) if kind == type(error).__name__ else f"{type(error).__name__}: {error}"
    return _packed("error", (kind, (text,), {}, notes), arena)


def unpack_answer(message: bytes, arena: Arena, max_bytes: int) -> tuple[bool, Any]:
    """Return whether the function has returned, and what it has returned or raised; arrays are the caller's own.

    Args:
        message: what was received.
        arena: memory in which the worker has put arrays.
        max_bytes: limit of their size.

    Raises:
        MalformedAnswerError: it is no answer.
    """
    try:
        kind, sizes, head = json.loads(message)
        parts = [part.copy() for part in _parts(sizes, arena, max_bytes)]
        value = _Reader(parts).read(head)
        if kind == "result":
            return True, value
        return False, _error(*value)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError, RecursionError) as error:
        raise MalformedAnswerError(f"an answer that cannot be read ({type(error).__name__}: {error})") from error


# --- writing ----------------------------------------------------------------------------------------------------------


def _packed(kind: str, value: object, arena: Arena) -> bytes:
    writer = _Writer()
    head = writer.write(value)
    starts, size = layout([len(raw) for raw in writer.raws])
    memory = arena.first(size)
    for start, raw in zip(starts, writer.raws, strict=True):
        memory[start : start + len(raw)] = raw
    return json.dumps([kind, [len(raw) for raw in writer.raws], head], separators=(",", ":")).encode()


class _Writer:
    """Makes JSON of values; arrays and bytes are set aside."""

    def __init__(self) -> None:
        self.raws: list[NDArray[np.uint8]] = []
        self._places: dict[int, tuple[object, int]] = {}
        """Places by identity: what is used twice is sent once."""

    def write(self, value: object) -> object:  # noqa: PLR0911 - one return per type
        match value:
            case Enum():
                return ["enum", _name(type(value)), value.name]
            case None | bool():
                return value
            case np.generic():
                _check_type(value.dtype)
                return ["scalar", value.dtype.str, self._place(value, lambda: np.asarray(value).tobytes())]
            case int() | float() | str():
                return value
            case bytes():
                return ["bytes", self._place(value, lambda: value)]
            case np.ndarray():
                _check_type(value.dtype)
                is_fortran = value.flags.f_contiguous and not value.flags.c_contiguous
                array = value.T if is_fortran else np.ascontiguousarray(value)
                place = self._place(value, lambda: array)
                return ["array", value.dtype.str, list(value.shape), is_fortran, place]
            case list():
                return ["list", [self.write(item) for item in value]]
            case tuple() if type(value) is tuple:
                return ["tuple", [self.write(item) for item in value]]
            case frozenset() | set():
                return ["set" if isinstance(value, set) else "frozenset", [self.write(item) for item in value]]
            case Mapping():
                return ["dict", [[self.write(key), self.write(item)] for key, item in value.items()]]
        if is_dataclass(value) and not isinstance(value, type):
            content = {field.name: self.write(getattr(value, field.name)) for field in fields(value)}
            return ["data", _name(type(value)), content]
        raise TypeError(f"a worker cannot answer with a {type(value).__name__}")

    def _place(self, value: object, raw: Callable[[], bytes | NDArray[Any]]) -> int:
        if id(value) not in self._places:
            content = raw()
            flat = content.reshape(-1).view(np.uint8) if isinstance(content, np.ndarray) else content
            self._places[id(value)] = value, len(self.raws)
            self.raws.append(flat if isinstance(flat, np.ndarray) else np.frombuffer(flat, np.uint8))
        return self._places[id(value)][1]


def _check_type(dtype: np.dtype[Any]) -> None:
    if not _ARRAY_TYPES.fullmatch(dtype.str):
        raise TypeError(f"a worker cannot answer with values of type {dtype}")


def _name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


# --- reading ----------------------------------------------------------------------------------------------------------


def _parts(sizes: list[int], arena: Arena, max_bytes: int) -> list[NDArray[np.uint8]]:
    if not all(type(size) is int and size >= 0 for size in sizes):
        raise ValueError("invalid sizes")
    starts, total = layout(sizes)
    if total > max_bytes:
        raise ValueError(f"{total} bytes of arrays, more than {max_bytes}")
    if total > arena.size():
        raise ValueError(f"{total} bytes of arrays in {arena.size()} bytes of memory")
    memory = arena.first(total)
    return [memory[start : start + size] for start, size in zip(starts, sizes, strict=True)]


class _Reader:
    """Makes values of JSON, strictly as :class:`_Writer` writes them."""

    def __init__(self, parts: list[NDArray[np.uint8]]) -> None:
        self._parts = parts
        self._bytes: dict[int, bytes] = {}
        """Bytes by their places: named often, they would take as much memory each time."""

    def read(self, head: object) -> Any:
        if head is None or isinstance(head, bool | int | float | str):
            return head
        if not isinstance(head, list):
            raise TypeError(f"a {type(head).__name__} among the values")
        tag, *rest = head
        if tag not in _TAGS:
            raise ValueError("an unknown kind of value")
        return getattr(self, f"_read_{tag}")(*rest)

    def _read_list(self, items: list[object]) -> list[object]:
        return [self.read(item) for item in items]

    def _read_tuple(self, items: list[object]) -> tuple[object, ...]:
        return tuple(self.read(item) for item in items)

    def _read_set(self, items: list[object]) -> set[object]:
        return {self.read(item) for item in items}

    def _read_frozenset(self, items: list[object]) -> frozenset[object]:
        return frozenset(self.read(item) for item in items)

    def _read_dict(self, items: list[tuple[object, object]]) -> dict[object, object]:
        return {self.read(key): self.read(item) for key, item in items}

    def _read_bytes(self, place: int) -> bytes:
        if place not in self._bytes:
            self._bytes[place] = self._part(place).tobytes()
        return self._bytes[place]

    def _read_scalar(self, dtype: str, place: int) -> Any:
        return self._typed(dtype, place).reshape(())[()]

    def _read_array(self, dtype: str, shape: list[int], is_fortran: bool, place: int) -> NDArray[Any]:
        if not all(type(edge) is int and edge >= 0 for edge in shape):
            raise ValueError("an invalid shape")
        values = self._typed(dtype, place)
        return values.reshape(shape[::-1]).T if is_fortran else values.reshape(shape)

    def _read_enum(self, name: str, member: str) -> object:
        kind = _loaded(name)
        if not issubclass(kind, Enum):
            raise TypeError(f"{name} is not an enumeration")
        return kind.__members__[member]

    def _read_data(self, name: str, content: dict[str, object]) -> object:
        kind = _loaded(name)
        if not is_dataclass(kind):
            raise TypeError(f"{name} is not a dataclass")
        names = [field.name for field in fields(kind)]
        if set(names) != content.keys():
            raise ValueError(f"{name} with other fields than its own")
        value = object.__new__(kind)
        for field in names:
            object.__setattr__(value, field, self.read(content[field]))
        return value

    def _part(self, place: int) -> NDArray[np.uint8]:
        if type(place) is not int or place < 0:
            raise IndexError("an array that is not there")
        return self._parts[place]

    def _typed(self, dtype: str, place: int) -> NDArray[Any]:
        if not isinstance(dtype, str) or not _ARRAY_TYPES.fullmatch(dtype):
            raise TypeError("an array of another type")
        return self._part(place).view(np.dtype(dtype))


_TAGS: Final = frozenset({"list", "tuple", "set", "frozenset", "dict", "bytes", "scalar", "array", "enum", "data"})


def _loaded(name: str) -> type[Any]:
    """Return a class of the program that is loaded already: loading a module would run it."""
    module, _, qualname = name.partition(":")
    if not module.startswith(_PACKAGES):
        raise KeyError(name)
    kind = vars(sys.modules[module])[qualname]
    if not isinstance(kind, type) or kind.__module__ != module:
        raise TypeError(f"{name} is not a class")
    return kind


def _error(name: str, arguments: tuple[object, ...], state: dict[str, object], notes: list[str]) -> Exception:
    kind: type[Exception] = _BUILTIN_ERRORS.get(name) or _loaded(name)
    if not issubclass(kind, AosError) and name not in _BUILTIN_ERRORS:
        raise TypeError(f"{name} is not an error")
    error = kind.__new__(kind)
    error.args = tuple(arguments)
    for attribute, value in state.items():
        if attribute.startswith("_") or not isinstance(attribute, str):
            raise ValueError("an error with attributes that are not its own")
        vars(error)[attribute] = value
    for note in notes:
        error.add_note(note)
    return error
