"""Declarations of strategies' parameters, from which checks, the API and the dashboard's form are made.

A parameter is a field of a frozen dataclass, made by :func:`declared`. A subclass that only wants another default
writes the field with that default and keeps the declaration.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, Final, TypeVar

from aos_gcs.errors import ParameterError

_KEY: Final = "declared"
_UNITS: Final = {"m": "m", "m2": "m²", "s": "s", "mps": "m/s", "deg": "°"}
T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """Bounds of a value; None: open."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None

    def hold(self, value: float) -> bool:
        """Return whether a value lies between them."""
        return (
            (self.above is None or value > self.above)
            and (self.at_least is None or value >= self.at_least)
            and (self.below is None or value < self.below)
            and (self.at_most is None or value <= self.at_most)
        )

    def __str__(self) -> str:
        bounds = {"above": self.above, "at least": self.at_least, "below": self.below, "at most": self.at_most}
        return " and ".join(f"{word} {bound:g}" for word, bound in bounds.items() if bound is not None)


@dataclass(frozen=True, slots=True)
class _Declaration:
    text: str
    bounds: Bounds


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a strategy."""

    name: str
    text: str
    """Effect of the parameter."""
    default: float | bool | None
    is_switch: bool
    """Whether it is true or false; otherwise it is a number."""
    is_optional: bool
    """May be None, which switches off what it is for."""
    bounds: Bounds

    @property
    def unit(self) -> str:
        """Unit by the end of the name, as in docs/conventions.md; empty for ratios and counts."""
        return _UNITS.get(self.name.rpartition("_")[2], "") if "_" in self.name else ""

    def converted(self, value: object) -> float | bool | None:
        """Return a user's value as the strategy takes it.

        Raises:
            ParameterError: it has the wrong type, or is out of bounds.
        """
        if self.is_switch:
            if not isinstance(value, bool):
                raise ParameterError(f"{self.name} must be true or false, but is {value!r}.", self.name)
            return value
        if value is None and self.is_optional:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ParameterError(f"{self.name} must be a number, but is {value!r}.", self.name)
        if not math.isfinite(value):
            raise ParameterError(f"{self.name} must be a finite number, but is {value}.", self.name)
        if not self.bounds.hold(value):
            raise ParameterError(f"{self.name} must be {self.bounds}, but is {value:g}.", self.name)
        return float(value)


def declared(default: T, text: str, **bounds: float) -> T:
    """Declare a field of parameters, to be written as its default.

    Args:
        default: default of the field.
        text: effect, in a sentence; the unit follows from the name.
        bounds: arguments of :class:`Bounds`.
    """
    made: T = field(default=default, metadata={_KEY: _Declaration(text, Bounds(**bounds))})
    return made


def parameters_of(kind: type[Any]) -> tuple[Parameter, ...]:
    """Return what a dataclass of parameters has, in the order of its fields; an undeclared one may be anything."""
    return tuple(_parameter(kind, item) for item in fields(kind))


def _parameter(kind: type[Any], item: Field[Any]) -> Parameter:
    inherited = (_own_fields(owner).get(item.name) for owner in kind.__mro__)
    declarations = (known.metadata[_KEY] for known in inherited if known is not None and _KEY in known.metadata)
    declaration = next(declarations, _Declaration("", Bounds()))
    if item.default is MISSING:
        raise TypeError(f"the parameter {item.name} of {kind.__name__} has no default")
    return Parameter(
        item.name,
        declaration.text,
        item.default,
        is_switch=item.type == "bool",
        is_optional="None" in str(item.type),
        bounds=declaration.bounds,
    )


def _own_fields(owner: type[Any]) -> Mapping[str, Field[Any]]:
    found: Mapping[str, Field[Any]] = getattr(owner, "__dataclass_fields__", {})
    return found
