"""Reading and checking of the configuration file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pydantic

from aos_gcs.config.exact import require_exact
from aos_gcs.config.model import ApiConfig, ServiceConfig
from aos_gcs.errors import ConfigurationError
from aos_gcs.input_values import problem_texts


def read_config(path: Path) -> ServiceConfig:
    """Read and check a TOML file.

    Raises:
        ConfigurationError: it cannot be read or is not valid; the text names the field.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigurationError(f"Cannot read the configuration {path}: {error.strerror or error}.") from error
    except UnicodeDecodeError as error:
        raise ConfigurationError(f"{path} is no text file (UTF-8): name the TOML file.") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{path} is not valid TOML: {error}.") from error
    return parse_config(table, source=str(path))


def parse_config(table: Mapping[str, Any], source: str = "configuration") -> ServiceConfig:
    """Check a configuration given as nested tables.

    Raises:
        ConfigurationError: it is not valid; the text names the field.
    """
    try:
        require_exact(ServiceConfig, table, "")
        return ServiceConfig.model_validate(table)
    except ConfigurationError as error:
        raise ConfigurationError(f"{source}: {error}") from error
    except pydantic.ValidationError as error:
        raise ConfigurationError(f"{source}: {first_problem(error)}") from error


def dashboard_of(host: str, port: int, operator_code_file: Path | None) -> ApiConfig:
    """Return the settings of a dashboard by the options of a command.

    Raises:
        ConfigurationError: a value cannot be used; the text names the option.
    """
    try:
        return ApiConfig(host=host, port=port, operator_code_file=operator_code_file)
    except pydantic.ValidationError as error:
        raise ConfigurationError(f"--{first_problem(error)}") from error


def first_problem(error: pydantic.ValidationError, place: str = "") -> str:
    """Return what is wrong first, with its field, and how many problems there are."""
    problems = problem_texts(error.errors(include_url=False), "The configuration", place)
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"{problems[0]}{more}."
