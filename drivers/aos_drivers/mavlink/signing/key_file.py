"""Signing keys on disk, and the times up to which they have been used, by us and by each sender."""

from __future__ import annotations

import stat
from collections.abc import Mapping
from pathlib import Path

from aos_drivers.mavlink.signing.signer import KEY_BYTES, Stream
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
    _replace(path, f"{ticks}\n")


def streams_file_of(key_file: Path) -> Path:
    """Return the file beside a key that remembers the latest time of each sender."""
    return key_file.with_name(key_file.name + ".streams")


def read_streams(path: Path) -> dict[Stream, int]:
    """Return the remembered times of senders; none where the file is missing or damaged.

    Then a sender has to be up to date within a minute: no reason to refuse to start while vehicles fly.
    """
    try:
        lines = path.read_text(encoding="ascii").splitlines()
        rows = [[int(word) for word in line.split()] for line in lines]
        return {(link_id, system_id, component_id): ticks for link_id, system_id, component_id, ticks in rows}
    except (OSError, ValueError):
        return {}


def write_streams(path: Path, latest_ticks: Mapping[Stream, int]) -> None:
    """Remember the times of senders, one line each: link id, system, component, time.

    Raises:
        OSError: the file cannot be written.
    """
    _replace(path, "".join(f"{' '.join(map(str, stream))} {ticks}\n" for stream, ticks in latest_ticks.items()))


def _replace(path: Path, text: str) -> None:
    draft = path.with_name(path.name + ".part")
    draft.touch(mode=_PRIVATE)
    draft.write_text(text, encoding="ascii")
    draft.replace(path)
