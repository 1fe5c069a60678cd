"""Addresses of tiles on a server, from the template that a user gives."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, field
from typing import Final
from urllib.parse import SplitResult, urlsplit

from aos_gcs.errors import ConfigurationError

_PLACEHOLDER: Final = re.compile(r"\{([^{}]*)\}")
_ROWS: Final = {"y", "-y"}
"""Rows counted from the north, as web maps do, and from the south, as TMS does."""
_REQUIRED: Final = {"z", "x"}
_SCHEMES: Final = {"https": 443, "http": 80}
_EXAMPLE: Final = "https://HOST/{z}/{x}/{y}.png"


@dataclass(frozen=True, slots=True)
class TileTemplate:
    """Template of a server's addresses. It may hold a key: messages name its host and nothing else."""

    host: str
    _text: str = field(repr=False)

    @classmethod
    def parsed(cls, text: str) -> TileTemplate:
        """Check a template, such as ``https://HOST/{z}/{x}/{y}.png``; ``{-y}`` counts rows from the south.

        Raises:
            ConfigurationError: it is no address of tiles; the text does not repeat it.
        """
        names = _PLACEHOLDER.findall(text)
        unknown = sorted(set(names) - _REQUIRED - _ROWS)
        if unknown:
            raise ConfigurationError(
                f"--tiles has the unknown placeholder {{{unknown[0][:20]}}}; known are {{z}}, {{x}}, and {{y}} or "
                "{-y}: write what the server expects in its place, such as one of its host names for {s}."
            )
        if not set(names) >= _REQUIRED or len(_ROWS.intersection(names)) != 1:
            raise ConfigurationError(f"--tiles needs the placeholders {{z}}, {{x}}, and {{y}} or {{-y}}: {_EXAMPLE}.")
        try:
            place = origin(text)
        except ValueError:
            place = None
        if place is None or _PLACEHOLDER.search(place[1]) or not text.isprintable():
            raise ConfigurationError(
                f"--tiles must be an address that begins with https:// or http:// and a host: {_EXAMPLE}."
            )
        return cls(place[1], text)

    @property
    def fingerprint(self) -> str:
        """Digest by which the template is known again; it does not show a key."""
        return hashlib.blake2b(self._text.encode(), digest_size=16).hexdigest()

    def address(self, zoom: int, column: int, row: int) -> str:
        """Return the address of a tile, whose row counts from the north."""
        values = {"z": zoom, "x": column, "y": row, "-y": (1 << zoom) - 1 - row}
        return _PLACEHOLDER.sub(lambda found: str(values[found[1]]), self._text)


def origin(address: str) -> tuple[str, str, int] | None:
    """Return scheme, host and port of an address; None where it is none of HTTP.

    Raises:
        ValueError: it is malformed.
    """
    split: SplitResult = urlsplit(address)
    if split.scheme not in _SCHEMES or not split.hostname:
        return None
    return split.scheme, split.hostname, _SCHEMES[split.scheme] if split.port is None else split.port
