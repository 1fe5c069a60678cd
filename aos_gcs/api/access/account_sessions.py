"""Sessions of accounts. A session ends with its account, with its password, or when it was not used for a day."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Callable, Mapping
from typing import Final, NoReturn

from aos_gcs.api.access.accounts import Account, AccountFile
from aos_gcs.api.access.operator_file import digest
from aos_gcs.api.access.passwords import is_password
from aos_gcs.api.access.roles import Session
from aos_gcs.errors import ConfigurationError

_log = logging.getLogger(__name__)

SESSIONS_PER_ACCOUNT: Final = 8
"""Devices of one person; another one replaces the earliest."""
UNUSED_S: Final = 24 * 3600.0
_REFRESH_S: Final = 1.0


class AccountSessions:
    """Sessions of accounts by the digests of their tokens, which are kept nowhere.

    Args:
        file: the accounts.
        known: identifiers of accounts by the digests of tokens, of an earlier run.
        now_s: clock in real seconds.
    """

    def __init__(self, file: AccountFile, known: Mapping[str, str], now_s: Callable[[], float]) -> None:
        self.file = file
        self._now_s = now_s
        self._account_ids = dict(known)
        self._used_s = dict.fromkeys(known, now_s())
        self._comparing = asyncio.Lock()

    def begin(self, account: Account) -> str:
        """Return the token of a new session."""
        of_account = [key for key, account_id in self._account_ids.items() if account_id == account.id]
        for key in of_account[: max(0, len(of_account) - SESSIONS_PER_ACCOUNT + 1)]:
            self._forget(key)
        token = secrets.token_urlsafe(32)
        self._account_ids[digest(token)] = account.id
        self._used_s[digest(token)] = self._now_s()
        return token

    def end(self, token: str) -> None:
        """End a session; nothing happens if there is none."""
        self._forget(digest(token))

    def session(self, token: str) -> Session | None:
        """Return the session behind a token, with the role that its account has now; None if there is none."""
        key, now_s = digest(token), self._now_s()
        if key not in self._account_ids:
            return None
        account = self.file.by_id(self._account_ids[key])
        if account is None or now_s - self._used_s[key] > UNUSED_S:
            self._forget(key)
            return None
        self._used_s[key] = now_s
        return Session(account.role, account.name)

    def count(self, account: Account) -> int:
        """Return the number of an account's sessions."""
        return sum(1 for account_id in self._account_ids.values() if account_id == account.id)

    def to_keep(self) -> dict[str, str]:
        """Return what outlasts a restart."""
        return dict(self._account_ids)

    async def find(self, name: str, password: str) -> Account | None:
        """Return the account of a name and its password; None if either is wrong, which takes the same time."""
        account = self.file.find(name)
        known_digest = None if account is None else account.password_digest
        async with self._comparing:  # one at a time: each takes 64 MiB and several cores
            return account if await asyncio.to_thread(is_password, known_digest, password) else None

    async def follow(self) -> NoReturn:
        """Read the accounts again whenever another process has changed them, until cancelled."""
        has_failed = False
        while True:
            await asyncio.sleep(_REFRESH_S)
            try:
                await asyncio.to_thread(self.file.refresh)
                has_failed = False
            except ConfigurationError as error:
                if not has_failed:
                    _log.warning("The accounts stay as they were: %s", error)
                has_failed = True

    def _forget(self, key: str) -> None:
        self._account_ids.pop(key, None)
        self._used_s.pop(key, None)
