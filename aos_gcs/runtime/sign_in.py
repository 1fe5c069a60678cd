"""The code by which operators sign in on the dashboard, and where it is shown."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.api.access.operator_code import random_code, read_code
from aos_gcs.api.access.operator_file import FILE_NAME, OperatorFile
from aos_gcs.api.listener import ServerAddress
from aos_gcs.config.model import ApiConfig

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class OperatorSecrets:
    """The code by which operators sign in, and the file that remembers who has."""

    code: str
    file: OperatorFile | None = None


def operator_secrets(config: ApiConfig, folder: Path | None = None) -> OperatorSecrets:
    """Return the code of the file that the configuration names, or else that of earlier starts, or a random one.

    Args:
        config: address and files of the dashboard.
        folder: folder in which code and sign-ins outlast a restart; None: neither does.

    Raises:
        ConfigurationError: the file of the code cannot be used.
    """
    given = None if config.operator_code_file is None else read_code(config.operator_code_file)
    if folder is None or not config.enabled:
        return OperatorSecrets(given or random_code())
    file = OperatorFile(folder / FILE_NAME)
    return OperatorSecrets(given or file.code(random_code()), file)


def announce(address: ServerAddress, config: ApiConfig, code: str) -> None:
    """Log the addresses that observers and operators open."""
    _log.info("Dashboard for observers: %s", address.url)
    if config.operator_code_file is None:
        # Behind the #, it is sent to no server and stands in no log of requests.
        _log.info("Dashboard for operators: %s#code=%s", address.url, code)
    else:
        _log.info("Operators sign in there with the code in %s.", config.operator_code_file)
