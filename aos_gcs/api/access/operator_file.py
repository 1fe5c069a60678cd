"""Operator code and sign-ins that outlast a restart of the service, in a file that only its owner may read."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ValidationError

_log = logging.getLogger(__name__)

FILE_NAME: Final = ".operators.json"
_OWNER_ONLY: Final = 0o600


class _Content(BaseModel):
    code: str = ""
    """Code that the service has made up; empty where the configuration names a file with one."""
    valid_for: str = ""
    """Digest of the code by which the operators have signed in: another code ends their sessions."""
    sessions: dict[str, str] = {}
    """Names of the operators by the digests of their tokens, in the order of their sign-in."""
    addresses: list[str] = []
    """Addresses that operators have sent requests from, the latest last."""
    control: str | None = None
    """Operator who has control."""


class OperatorFile:
    """Remembers the operator code and who has signed in.

    What cannot be read counts as empty, and what cannot be written is reported in the log: neither keeps the service
    from running.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._content = self._read()

    def code(self, new_code: str) -> str:
        """Return the code of earlier starts, or keep and return a new one."""
        if not self._content.code:
            self._content = _Content(code=new_code)
            self._write()
        return self._content.code

    def sessions(self, code: str) -> dict[str, str]:
        """Return the names of those who have signed in by this code, by the digests of their tokens."""
        return dict(self._content.sessions) if self._content.valid_for == digest(code) else {}

    def addresses(self, code: str) -> tuple[str, ...]:
        """Return the addresses that operators by this code have sent requests from, the latest last."""
        return tuple(self._content.addresses) if self._content.valid_for == digest(code) else ()

    def control(self, code: str) -> str | None:
        """Return who of the operators by this code has control."""
        return self._content.control if self._content.valid_for == digest(code) else None

    def keep(
        self, code: str, sessions: Mapping[str, str], addresses: Sequence[str], control: str | None = None
    ) -> None:
        """Write down who is signed in, and where, and who has control."""
        with self._lock:
            self._content = _Content(
                code=self._content.code,
                valid_for=digest(code),
                sessions=dict(sessions),
                addresses=list(addresses),
                control=control,
            )
            self._write()

    def _read(self) -> _Content:
        try:
            return _Content.model_validate_json(self._path.read_bytes())
        except FileNotFoundError:
            return _Content()
        except (OSError, ValidationError) as error:
            _log.warning("Sign-ins of operators cannot be read from %s: %s", self._path, error)
            return _Content()

    def _write(self) -> None:
        unfinished = self._path.with_name(self._path.name + ".new")
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            unfinished.unlink(missing_ok=True)
            descriptor = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _OWNER_ONLY)
            with os.fdopen(descriptor, "w", encoding="utf-8") as file:
                json.dump(self._content.model_dump(), file)
            unfinished.replace(self._path)
        except OSError as error:
            _log.warning("Operators have to sign in again after a restart: %s cannot be written: %s", self._path, error)


def digest(secret: str) -> str:
    """Return what is written down in the place of a secret."""
    return hashlib.sha256(secret.encode()).hexdigest()
