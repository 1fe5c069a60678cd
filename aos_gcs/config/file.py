"""Reading and checking of the configuration file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pydantic

from aos_gcs.config.model import ServiceConfig
from aos_gcs.config.numbers import require_numbers
from aos_gcs.errors import ConfigurationError


def read_config(path: Path) -> ServiceConfig:
    """Read and check a TOML file.

    Raises:
        ConfigurationError: it cannot be read or is not valid; the text names the field.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"Cannot read the configuration {path}: {error}.") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{path} is not valid TOML: {error}.") from error
    return parse_config(table, source=str(path))


def parse_config(table: Mapping[str, Any], source: str = "configuration") -> ServiceConfig:
    """Check a configuration given as nested tables.

    Raises:
        ConfigurationError: it is not valid; the text names the field.
    """
    try:
        require_numbers(ServiceConfig, table, "")
        return ServiceConfig.model_validate(table)
    except ConfigurationError as error:
        raise ConfigurationError(f"{source}: {error}") from error
    except pydantic.ValidationError as error:
        raise ConfigurationError(f"{source}: {first_problem(error)}") from error


def first_problem(error: pydantic.ValidationError) -> str:
    """Return 'field: what is wrong' of the first of the problems, and how many there are."""
    problems = error.errors(include_url=False, include_context=False)
    first = problems[0]
    field = ".".join(str(part) for part in first["loc"])
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"{field}: {first['msg']}{more}."
