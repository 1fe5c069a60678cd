"""The code by which operators sign in: given in a file, or random."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Final

from aos_gcs.errors import ConfigurationError

MIN_CODE_LENGTH: Final = 8
_CODE_BYTES: Final = 12


def random_code() -> str:
    """Return a code that cannot be guessed."""
    return secrets.token_urlsafe(_CODE_BYTES)


def read_code(path: Path) -> str:
    """Return the code in a file, without the blanks around it.

    Raises:
        ConfigurationError: the file cannot be read, or the code is too short.
    """
    try:
        code = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"The operator code cannot be read from {path}: {error}.") from error
    if len(code) < MIN_CODE_LENGTH:
        raise ConfigurationError(
            f"The operator code in {path} must have {MIN_CODE_LENGTH} or more characters, but has {len(code)}."
        )
    return code
