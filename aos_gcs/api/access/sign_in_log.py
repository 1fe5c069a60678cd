"""The log of sign-ins: who signed in and out, from where, and which passwords were wrong."""

from __future__ import annotations

import json
import logging
import os
import threading
from collections import deque
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Final

_log = logging.getLogger(__name__)

MAX_BYTES: Final = 2 * 2**20
"""Size at which a file is put aside; the one before it is removed then."""
KEPT: Final = 200
"""Latest entries, which administrators see on the page."""
_OWNER_ONLY: Final = 0o600


class SignInKind(StrEnum):
    """What has happened."""

    SIGNED_IN = "signed in"
    SIGNED_OUT = "signed out"
    WRONG = "wrong password"
    LOCKED = "too many wrong passwords"
    JOINED = "account made by invitation"
    PASSWORD = "password changed"  # noqa: S105 - a name
    INVITED = "invitation made"
    ROLE = "role changed"
    REMOVED = "account removed"


@dataclass(frozen=True, slots=True)
class SignInEntry:
    """Entry of the log."""

    utc_s: float
    kind: SignInKind
    name: str
    """Account, as it was given: a wrong one may be anything."""
    address: str
    detail: str = ""


class SignInLog:
    """Appends entries to a file, one line of JSON each; a file that cannot be written is reported once.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._has_failed = False
        self.latest: deque[SignInEntry] = deque(self._read_latest(), maxlen=KEPT)

    def write(self, entry: SignInEntry) -> None:
        """Append an entry."""
        with self._lock:
            self.latest.append(entry)
            try:
                self._append(json.dumps(asdict(entry)) + "\n")
            except OSError as error:
                if not self._has_failed:
                    _log.warning("Sign-ins cannot be logged in %s: %s", self._path, error)
                self._has_failed = True

    def _append(self, line: str) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        if self._path.exists() and self._path.stat().st_size > MAX_BYTES:
            self._path.replace(self._path.with_name(self._path.name + ".1"))
        descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, _OWNER_ONLY)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(line)

    def _read_latest(self) -> list[SignInEntry]:
        try:
            lines = self._path.read_text(encoding="utf-8").splitlines()[-KEPT:]
        except (OSError, UnicodeDecodeError):
            return []
        return [entry for line in lines if (entry := _parsed(line)) is not None]


def _parsed(line: str) -> SignInEntry | None:
    """Return an entry; None for a line that was cut off."""
    try:
        fields = json.loads(line)
        return SignInEntry(
            float(fields["utc_s"]),
            SignInKind(fields["kind"]),
            *(str(fields[key]) for key in ("name", "address", "detail")),
        )
    except (ValueError, TypeError, KeyError):
        return None
