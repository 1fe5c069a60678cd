"""Numbers and texts that others have written, in files or as their names, and the files that they name."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from aos_gcs.errors import InputDataError

_MAX_SHOWN = 100
_PROBLEMS: Final = {
    "missing": "is missing",
    "extra_forbidden": "is unknown; check its name",
    "greater_than_equal": "must be at least {ge}",
    "greater_than": "must be above {gt}",
    "less_than_equal": "must be at most {le}",
    "less_than": "must be below {lt}",
    "finite_number": "must be a finite number",
    "enum": "must be {expected}",
    "literal_error": "must be {expected}",
    "string_too_short": "must have {min_length} characters or more",
    "string_too_long": "must have {max_length} characters at most",
    "too_short": "must have {min_length} entries or more, but has {actual_length}",
    "too_long": "must have {max_length} entries at most",
    "json_invalid": "is no JSON",
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), "must be a whole number"),
    **dict.fromkeys(("float_type", "float_parsing"), "must be a number"),
    **dict.fromkeys(("bool_type", "bool_parsing"), "must be true or false"),
    **dict.fromkeys(("list_type", "tuple_type"), "must be a list"),
    **dict.fromkeys(("dict_type", "model_type", "model_attributes_type", "dataclass_type"), "must be a table"),
    "string_type": "must be text",
}
"""Types of pydantic's errors in the words of this program."""


def finite_numbers(text: str) -> list[float]:
    """Return numbers separated by commas; none at all unless all of them are finite."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []


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


def problem_texts(errors: Iterable[Mapping[str, Any]], whole: str, place: str = "") -> list[str]:
    """Return what is wrong with a document as sentences without a full stop, each with the field and the remedy.

    Args:
        errors: errors as pydantic lists them.
        whole: name of the document, where a problem is none of a single field.
        place: field that holds the document.
    """
    texts = []
    for error in errors:
        parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in error["loc"]]
        field = "".join((place, *parts)).removeprefix(".") or whole
        words = _PROBLEMS.get(error["type"])
        if words is None:
            told = error["msg"].removeprefix("Value error, ").removesuffix(".")
            texts.append(f"{field}: {told}" if parts or place else told)
        else:
            limits = {name: f"{one:g}" if isinstance(one, float) else one for name, one in error.get("ctx", {}).items()}
            texts.append(f"{field} {words.format_map(limits)}")
    return texts
