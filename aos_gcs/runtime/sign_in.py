"""The code by which operators sign in on the dashboard, and where it is shown."""

from __future__ import annotations

import logging
import os
import sys
import threading
import webbrowser
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.operator_code import random_code, read_code
from aos_gcs.api.access.operator_file import FILE_NAME, OperatorFile
from aos_gcs.api.access.roles import Role
from aos_gcs.api.listener import ServerAddress
from aos_gcs.api.tls import fingerprint
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError
from aos_gcs.runtime.encryption import address_for_phones, qr_text, tls_files

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class OperatorSecrets:
    """The code by which operators sign in or the accounts of everybody, and the file that remembers who has."""

    code: str
    file: OperatorFile | None = None
    accounts: AccountFile | None = None


def operator_secrets(config: ApiConfig, folder: Path | None = None) -> OperatorSecrets:
    """Return the code of the file that the configuration names, or else that of earlier starts, or a random one.

    Args:
        config: address and files of the dashboard.
        folder: folder in which code and sign-ins outlast a restart; None: neither does.

    Raises:
        ConfigurationError: the file of the code, or of the accounts, cannot be used.
    """
    accounts = None if config.accounts is None or not config.enabled else open_accounts(config.accounts)
    given = None if config.operator_code_file is None else read_code(config.operator_code_file)
    if folder is None or not config.enabled:
        return OperatorSecrets(given or random_code(), accounts=accounts)
    file = OperatorFile(folder / FILE_NAME)
    return OperatorSecrets(given or file.code(random_code()), file, accounts)


def open_accounts(path: Path) -> AccountFile:
    """Return the accounts of a file.

    Raises:
        ConfigurationError: it is damaged, or nobody in it may fly.
    """
    accounts = AccountFile(path)
    if not any(account.role.may(Role.OPERATOR) for account in accounts.all()):
        raise ConfigurationError(
            f"api.accounts: nobody in {path} may fly. Add somebody: "
            f"aos-gcs accounts add {path} NAME --role administrator."
        )
    return accounts


def announce(address: ServerAddress, config: ApiConfig, code: str) -> None:
    """Log the addresses that observers and operators open, and how they recognize the station; open one if asked to."""
    _announce_encryption(address, config)
    is_code_given = config.accounts is None and config.operator_code_file is None
    if config.open_browser:
        _open(f"{address.url}#code={code}" if is_code_given else address.url)
    if config.accounts is not None:
        _log.info("Dashboard: %s. Everybody signs in with an account of %s.", address.url, config.accounts)
        return
    _log.info("Dashboard for observers: %s", address.url)
    if config.operator_code_file is None:
        # Behind the #, it is sent to no server and stands in no log of requests.
        _log.info("Dashboard for operators: %s#code=%s", address.url, code)
    else:
        _log.info("Operators sign in there with the code in %s.", config.operator_code_file)


def _open(url: str) -> None:
    """Open an address in the browser of this machine, which the service does not wait for."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        # Without a screen it would be a text browser, which takes the terminal over.
        _log.warning("No browser was opened: this terminal has no screen. Open the address below.")
        return

    def open_it() -> None:
        if not webbrowser.open(url):
            _log.warning("No browser was opened: none was found. Open the address below.")

    threading.Thread(target=open_it, name="browser", daemon=True).start()


def _announce_encryption(address: ServerAddress, config: ApiConfig) -> None:
    files = tls_files(config)
    if files is not None:
        _log.info("Certificate %s, SHA-256 fingerprint %s", files.certificate, fingerprint(files.certificate))
    phones = address_for_phones(address)
    code = None if phones is None or not sys.stderr.isatty() else qr_text(phones.url)
    if phones is not None and code is not None:
        _log.info("For phones: %s\n%s", phones.url, code)
