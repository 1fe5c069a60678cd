"""Reading a table of options, with errors that name the option and the remedy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from aos_gcs.errors import ConfigurationError


class OptionTable:
    """The options of a driver, or a table within them."""

    def __init__(self, values: Mapping[str, object], place: str) -> None:
        """``place`` is the table's name in the configuration, such as ``link.options``."""
        self._values = values
        self.place = place

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def refuse_unknown(self, known: Iterable[str]) -> None:
        """Raise ConfigurationError if there is an option that is none of ``known``."""
        names = sorted(known)
        unknown = sorted(set(self._values) - set(names))
        if unknown:
            raise ConfigurationError(f"{self.place}.{unknown[0]} is unknown: use {', '.join(names)}")

    def number(self, name: str, default: float, low: float, high: float) -> float:
        """Return a number from ``low`` to ``high``, or raise ConfigurationError."""
        value = self._values.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise self.error(name, f"a number of {low:g} to {high:g}")
        return float(value)

    def optional_number(self, name: str, low: float, high: float) -> float | None:
        """Return a number from ``low`` to ``high``, None if it is not given, or raise ConfigurationError."""
        return self.number(name, low, low, high) if name in self else None

    def integer(self, name: str, default: int) -> int:
        """Return a whole number, or raise ConfigurationError."""
        value = self._values.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(name, "a whole number")
        return value

    def flag(self, name: str, default: bool) -> bool:
        """Return true or false, or raise ConfigurationError."""
        value = self._values.get(name, default)
        if not isinstance(value, bool):
            raise self.error(name, "true or false")
        return value

    def text(self, name: str) -> str | None:
        """Return a text, None if it is not given, or raise ConfigurationError."""
        value = self._values.get(name)
        if value is not None and (not isinstance(value, str) or not value.strip()):
            raise self.error(name, "a text")
        return value

    def texts(self, name: str, what: str) -> tuple[str, ...]:
        """Return a list of texts, or raise ConfigurationError; ``what`` names their kind in its text."""
        value = self._values.get(name, ())
        if not isinstance(value, list | tuple) or not all(isinstance(item, str) for item in value):
            raise self.error(name, f"a list of {what}")
        return tuple(value)

    def triple(self, name: str, default: tuple[float, float, float], limit: float) -> tuple[float, float, float]:
        """Return three numbers of a size of at most ``limit``, or raise ConfigurationError."""
        match self._values.get(name, default):
            case [int() | float() as first, int() | float() as second, int() | float() as third]:
                values = (float(first), float(second), float(third))
                if all(abs(value) <= limit for value in values):
                    return values
        raise self.error(name, f"three numbers of at most {limit:g}")

    def table(self, name: str) -> OptionTable:
        """Return a table within this one, empty if it is not given, or raise ConfigurationError."""
        return OptionTable(self.mapping(name), f"{self.place}.{name}")

    def mapping(self, name: str) -> Mapping[str, object]:
        """Return the values of a table within this one, or raise ConfigurationError."""
        value = self._values.get(name, {})
        if not isinstance(value, Mapping):
            raise self.error(name, "a table")
        return value

    def error(self, name: str, expected: str) -> ConfigurationError:
        """Return the error of an option that is not what it must be."""
        return ConfigurationError(f"{self.place}.{name} must be {expected}, got {self._values.get(name)!r}")
