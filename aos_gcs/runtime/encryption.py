"""Encryption of the dashboard by its configuration, and what is printed about it."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Final

from aos_gcs.api.listener import ServerAddress
from aos_gcs.api.tls import TlsFiles, local_addresses, own_certificate, server_context
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError
from aos_gcs.extras import load_extra

_ANY: Final = frozenset({"0.0.0.0", "::"})  # noqa: S104 - compared, not bound to


def with_certificate(config: ApiConfig, folder: Path, now: datetime) -> ApiConfig:
    """Return the configuration with the files of its certificate, which has been made and loaded once.

    Args:
        config: address and files of the dashboard.
        folder: folder of the station's own certificate.
        now: present time.

    Raises:
        ConfigurationError: the certificate cannot be made or used.
    """
    if not config.enabled or not (config.tls or config.tls_cert):
        return config
    files = own_certificate(folder, now) if config.tls_cert is None else tls_files(config)
    if files is None:
        return config
    server_context(files)
    return config.model_copy(update={"tls_cert": files.certificate, "tls_key": files.key})


def tls_files(config: ApiConfig) -> TlsFiles | None:
    """Return the files of the certificate; None where connections are not encrypted."""
    return None if config.tls_cert is None else TlsFiles(config.tls_cert, config.tls_key or config.tls_cert)


def address_for_phones(address: ServerAddress) -> ServerAddress | None:
    """Return the address under which other machines reach the dashboard; None if they do not, or it is unknown."""
    if address.host in _ANY:
        found = next(iter(local_addresses()), None)
        return None if found is None else ServerAddress(found, address.port, address.is_encrypted)
    is_here = address.host in {"localhost", "::1"} or address.host.startswith("127.")
    return None if is_here else address


def qr_text(text: str) -> str | None:
    """Return a QR code in characters, two modules above each other in one; None where the library is missing."""
    try:
        segno = load_extra("segno", "team", "A QR code")
    except ConfigurationError:
        return None
    rows = [list(row) for row in segno.make(text, micro=False).matrix_iter(border=2)]
    rows += [[0] * len(rows[0])] * (len(rows) % 2)
    # Light modules are drawn: terminals have dark backgrounds.
    characters = {(0, 0): "█", (0, 1): "▀", (1, 0): "▄", (1, 1): " "}
    pairs = zip(rows[::2], rows[1::2], strict=True)
    return "\n".join(
        "".join(characters[int(bool(upper)), int(bool(lower))] for upper, lower in zip(*pair, strict=True))
        for pair in pairs
    )
