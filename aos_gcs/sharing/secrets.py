"""Secrets of the receivers: from a file or the environment, never from the configuration, which is recorded."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from aos_gcs.errors import ConfigurationError

_MAX_BYTES = 4096


def read_secret(field: str, file: str | None, variable: str, environment: Mapping[str, str]) -> str:
    """Return a secret without the blanks around it.

    Args:
        field: field of the configuration that names the file.
        file: file that holds the secret and nothing else; None: it is in the environment.
        variable: variable of the environment.
        environment: variables.

    Raises:
        ConfigurationError: it is nowhere, or the file cannot be read; the text never holds what was read.
    """
    if file is None:
        secret = environment.get(variable, "").strip()
        if not secret:
            raise ConfigurationError(f"{field}: name the file of the secret, or set the variable {variable}.")
        return secret
    try:
        with Path(file).open("rb") as opened:
            secret = opened.read(_MAX_BYTES).decode("ascii").strip()
    except OSError as error:
        raise ConfigurationError(f"{field}: cannot read {file} ({error.strerror}).") from error
    except UnicodeDecodeError:
        secret = ""
    if not secret:
        raise ConfigurationError(f"{field}: {file} holds no secret; write it there as one line of text.")
    return secret
