"""Signing keys on disk, and the time up to which they have been used."""

from __future__ import annotations

import stat
from pathlib import Path

from aos_drivers.mavlink.signing.signer import KEY_BYTES
from aos_gcs.errors import ConfigurationError

_OTHERS = stat.S_IRWXG | stat.S_IRWXO
_PRIVATE = 0o600


def read_key(path: Path) -> bytes:
    """Return the key: the file holds 64 hexadecimal digits, or 32 bytes as they are.

    Raises:
        ConfigurationError: it cannot be read, others may read it, or it holds no key.
    """
    try:
        with path.open("rb") as file:
            if path.stat().st_mode & _OTHERS:
                raise ConfigurationError(f"the key {path} may be read by others: run chmod 600 {path}")
            content = file.read(KEY_BYTES * 4)
    except OSError as error:
        raise ConfigurationError(f"the key {path} cannot be read: {error.strerror}; check sign= of the link") from error
    if len(content) == KEY_BYTES:
        return content
    try:
        key = bytes.fromhex(content.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise ConfigurationError(f"{path} holds no key: write 64 hexadecimal digits, as openssl rand -hex 32 does")
    return key


def time_file_of(key_file: Path) -> Path:
    """Return the file beside a key that remembers how far its time has been used."""
    return key_file.with_name(key_file.name + ".time")


def read_ticks(path: Path) -> int:
    """Return the remembered signature time; 0 if there is none.

    Raises:
        ConfigurationError: the file is unreadable or damaged.
    """
    try:
        return int(path.read_text(encoding="ascii"))
    except FileNotFoundError:
        return 0
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"{path} cannot be understood: delete it if this computer's clock is right, as packets would be refused "
            "by vehicles that have seen a later time"
        ) from error


def write_ticks(path: Path, ticks: int) -> None:
    """Remember a signature time; a crash leaves either the old one or the new one.

    Raises:
        OSError: the file cannot be written.
    """
    draft = path.with_name(path.name + ".part")
    draft.touch(mode=_PRIVATE)
    draft.write_text(f"{ticks}\n", encoding="ascii")
    draft.replace(path)
