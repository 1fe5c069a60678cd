"""Numbers and texts that others have written, in files or as their names, and the files that they name."""

from __future__ import annotations

import math
import unicodedata
from pathlib import Path

from aos_gcs.errors import InputDataError

_MAX_SHOWN = 100


def finite_number(value: object) -> float | None:
    """Return a number of a JSON or TOML document; None where it is none, not finite, or too large for a float."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def shown(value: object) -> str:
    """Return a value of a document for a message, shortened."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):
        return "a value that is too long to be shown"
    return text if len(text) <= _MAX_SHOWN else f"{text[: _MAX_SHOWN - 3]}..."


def printable(text: str, keep: str = "") -> str:
    """Return a text whose control characters, and bytes that are no UTF-8, are escaped.

    Names of files may hold both: a terminal would obey the first, and no stream takes the second.

    Args:
        text: the text.
        keep: control characters that stay.
    """
    return "".join(
        one if one in keep or not unicodedata.category(one).startswith("C") else ascii(one)[1:-1] for one in text
    )


def require_file(path: Path, name: str) -> None:
    """Refuse what is not there, and what would be waited for, such as a pipe.

    Raises:
        InputDataError: the path names no file; the text begins with ``name``.
    """
    if not path.is_file():
        raise InputDataError(
            f"{name} cannot be read: it is not a file." if path.exists() else f"{name} does not exist; check the path."
        )


def require_folder(path: Path, name: str) -> None:
    """Refuse what is not there, and files.

    Raises:
        InputDataError: the path names no folder; the text begins with ``name``.
    """
    if not path.is_dir():
        raise InputDataError(
            f"{name} is a file; name the folder that holds the images."
            if path.exists()
            else f"{name} does not exist; check the path."
        )
