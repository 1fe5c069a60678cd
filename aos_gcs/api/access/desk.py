"""What is done with accounts, each with its entry in the log of sign-ins."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from aos_gcs.api.access.account_sessions import AccountSessions
from aos_gcs.api.access.accounts import Account, AccountFile
from aos_gcs.api.access.roles import Role
from aos_gcs.api.access.sign_in_log import SignInEntry, SignInKind, SignInLog

_LOCKED_EVERY_S: Final = 10.0
"""Entries about passwords that were not compared: an attacker must not fill the log."""
_WRITTEN_WITHIN_S: Final = 1.0


class AccountDesk:
    """Changes accounts for their owners and for administrators.

    Args:
        sessions: sessions of the accounts.
        log: log of sign-ins.
        utc_s: seconds since the Unix epoch.
    """

    def __init__(self, sessions: AccountSessions, log: SignInLog, utc_s: Callable[[], float]) -> None:
        self.sessions = sessions
        self.log = log
        self._utc_s = utc_s
        self._locked_utc_s = 0.0

    @property
    def _file(self) -> AccountFile:
        return self.sessions.file

    async def note(self, kind: SignInKind, name: str, address: str) -> None:
        """Write an entry to the log; a disk that hangs keeps nobody waiting."""
        with suppress(TimeoutError):
            async with asyncio.timeout(_WRITTEN_WITHIN_S):
                await asyncio.to_thread(self._write, kind, name, address)

    async def note_locked(self, name: str, address: str) -> None:
        """Write an entry about a password that was not compared, unless there was one a moment ago."""
        if self._utc_s() - self._locked_utc_s >= _LOCKED_EVERY_S:
            self._locked_utc_s = self._utc_s()
            await self.note(SignInKind.LOCKED, name, address)

    def accept(self, token: str, name: str, password: str, address: str) -> Account:
        """Make an account by an invitation; see ``AccountFile.accept``."""
        account = self._file.accept(token, name, password, self._utc_s())
        self._write(SignInKind.JOINED, name, address, account.role)
        return account

    def set_password(self, name: str, password: str, address: str) -> Account:
        """Give an account another password; see ``AccountFile.set_password``."""
        account = self._file.set_password(name, password)
        self._write(SignInKind.PASSWORD, name, address)
        return account

    def invite(self, role: Role, by: str, address: str) -> str:
        """Return the token of a new invitation; see ``AccountFile.invite``."""
        token = self._file.invite(role, by, self._utc_s())
        self._write(SignInKind.INVITED, by, address, role)
        return token

    def set_role(self, name: str, role: Role, by: str, address: str) -> None:
        """Give an account another role, but keep one administrator; see ``AccountFile.set_role``."""
        self._file.set_role(name, role, keep_administrator=True)
        self._write(SignInKind.ROLE, by, address, f"{name}: {role}")

    def remove(self, name: str, by: str, address: str) -> None:
        """Remove an account, but keep one administrator; see ``AccountFile.remove``."""
        self._file.remove(name, keep_administrator=True)
        self._write(SignInKind.REMOVED, by, address, name)

    def _write(self, kind: SignInKind, name: str, address: str, detail: str = "") -> None:
        self.log.write(SignInEntry(self._utc_s(), kind, name, address, detail))
