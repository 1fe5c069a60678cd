"""Accounts of the people at a command post, in a file that the service and ``aos-gcs accounts`` change."""

from __future__ import annotations

import fcntl
import json
import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, StringConstraints, TypeAdapter, ValidationError

from aos_gcs.api.access.operator_file import digest
from aos_gcs.api.access.passwords import check_password, hash_password
from aos_gcs.api.access.roles import Role
from aos_gcs.errors import AosError, ConfigurationError, InputDataError
from aos_gcs.input_values import problem_texts

MAX_ACCOUNTS: Final = 200
MAX_INVITATIONS: Final = 50
INVITATION_LASTS_S: Final = 24 * 3600.0
_OWNER_ONLY: Final = 0o600
NAME_PATTERN: Final = r"^[^\s/\x00-\x1f\x7f]([^/\x00-\x1f\x7f]*[^\s/\x00-\x1f\x7f])?$"

AccountName = Annotated[str, StringConstraints(min_length=1, max_length=40, pattern=NAME_PATTERN)]
_NAME: Final[TypeAdapter[str]] = TypeAdapter(AccountName)


class AccountError(AosError):
    """A change of accounts that is not made."""


class InvitationError(AosError):
    """An invitation that is unknown, used, or has expired."""


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str
    """Tells apart accounts that have had one name after the other."""
    name: AccountName
    role: Role
    password: str
    """Digest by Argon2id."""
    created_utc_s: float


class _Invitation(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    token: str
    """Digest of the token."""
    role: Role
    expires_utc_s: float
    invited_by: str


class _Content(BaseModel):
    model_config = ConfigDict(extra="forbid")

    accounts: list[_Entry] = []
    invitations: list[_Invitation] = []


@dataclass(frozen=True, slots=True)
class Account:
    """Account of a person."""

    id: str
    name: str
    role: Role
    password_digest: str
    created_utc_s: float


class AccountFile:
    """Accounts and invitations.

    What another process has written is read by :meth:`refresh`; every change reads the file anew, under a lock.

    Args:
        path: file; without it there are no accounts yet.

    Raises:
        ConfigurationError: it cannot be read, or is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stamp: tuple[int, int, int] | None = None
        self._accounts: dict[str, Account] = {}
        self._by_id: dict[str, Account] = {}
        self.refresh()

    def refresh(self) -> None:
        """Read the file again if it has changed.

        Raises:
            ConfigurationError: it cannot be read, or is damaged; the accounts stay as they were.
        """
        if (stamp := self._look()) != self._stamp:
            self._take(self._read(), stamp)

    def all(self) -> tuple[Account, ...]:
        """Return all accounts, by name."""
        return tuple(sorted(self._accounts.values(), key=lambda account: account.name.casefold()))

    def find(self, name: str) -> Account | None:
        """Return the account of a name, whatever its capitals."""
        return self._accounts.get(name.casefold())

    def by_id(self, account_id: str) -> Account | None:
        """Return the account behind a session."""
        return self._by_id.get(account_id)

    def add(self, name: str, role: Role, password: str, utc_s: float) -> Account:
        """Add an account.

        Raises:
            AccountError: there is one of that name, or there are too many.
            InputDataError: name, role or password cannot be used.
        """
        entry = _new_entry(name, role, password, utc_s)
        with self._changing() as content:
            _add(content, entry)
        return self._by_id[entry.id]

    def remove(self, name: str, *, keep_administrator: bool = False) -> None:
        """Remove an account; its sessions end.

        Args:
            name: name of the account.
            keep_administrator: refuse to remove the last one.

        Raises:
            AccountError: there is none of that name, or it has to stay.
        """
        self._change(name, lambda _: None, keep_administrator=keep_administrator)

    def set_role(self, name: str, role: Role, *, keep_administrator: bool = False) -> None:
        """Give an account another role; see :meth:`remove`."""
        _check_role(role)
        self._change(name, lambda entry: entry.model_copy(update={"role": role}), keep_administrator=keep_administrator)

    def set_password(self, name: str, password: str) -> Account:
        """Give an account another password; all of its sessions end.

        Raises:
            AccountError: there is none of that name.
            InputDataError: the password cannot be used.
        """
        check_password(password, name)
        changed = {"password": hash_password(password), "id": _new_id()}
        self._change(name, lambda entry: entry.model_copy(update=changed))
        return self._by_id[changed["id"]]

    def invite(self, role: Role, invited_by: str, utc_s: float, lasts_s: float = INVITATION_LASTS_S) -> str:
        """Return the token of a new invitation, which is kept nowhere.

        Raises:
            AccountError: there are too many.
            InputDataError: the role needs no invitation.
        """
        _check_role(role)
        token = secrets.token_urlsafe(24)
        made = _Invitation(token=digest(token), role=role, expires_utc_s=utc_s + lasts_s, invited_by=invited_by)
        with self._changing() as content:
            content.invitations = [one for one in content.invitations if one.expires_utc_s > utc_s]
            if len(content.invitations) >= MAX_INVITATIONS:
                raise AccountError(f"There are {MAX_INVITATIONS} open invitations; wait until some have expired.")
            content.invitations.append(made)
        return token

    def accept(self, token: str, name: str, password: str, utc_s: float) -> Account:
        """Add the account of a person who was invited; an invitation serves once.

        Raises:
            InvitationError: it is unknown, used, or has expired.
            AccountError: the name is taken.
            InputDataError: name or password cannot be used.
        """
        self._find_invitation(self._read(), token, utc_s)  # before the expensive part
        entry = _new_entry(name, Role.OBSERVER, password, utc_s)
        with self._changing() as content:
            invitation = self._find_invitation(content, token, utc_s)
            content.invitations.remove(invitation)
            _add(content, entry.model_copy(update={"role": invitation.role}))
        return self._by_id[entry.id]

    @staticmethod
    def _find_invitation(content: _Content, token: str, utc_s: float) -> _Invitation:
        for one in content.invitations:
            if secrets.compare_digest(one.token, digest(token)) and one.expires_utc_s > utc_s:
                return one
        raise InvitationError("This invitation is unknown, was used, or has expired. Ask for a new one.")

    def _change(
        self, name: str, change: Callable[[_Entry], _Entry | None], *, keep_administrator: bool = False
    ) -> None:
        with self._changing() as content:
            kept = [entry for entry in content.accounts if entry.name.casefold() != name.casefold()]
            if len(kept) == len(content.accounts):
                raise AccountError(f"There is no account '{name}'.")
            changed = [change(entry) for entry in content.accounts if entry not in kept]
            content.accounts = [*kept, *(entry for entry in changed if entry is not None)]
            if keep_administrator and not any(entry.role is Role.ADMINISTRATOR for entry in content.accounts):
                raise AccountError(f"'{name}' is the last administrator. Make another one first.")

    @contextmanager
    def _changing(self) -> Iterator[_Content]:
        """Give the file's content to be changed, then write it; nobody else writes meanwhile."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.with_name(self.path.name + ".lock").open("a") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                content = self._read()
                yield content
                self._write(content)
                self._take(content, self._look())
        except OSError as error:
            raise ConfigurationError(f"The accounts cannot be changed in {self.path}: {error}.") from error

    def _read(self) -> _Content:
        try:
            return _Content.model_validate_json(self.path.read_bytes())
        except FileNotFoundError:
            return _Content()
        except OSError as error:
            raise ConfigurationError(f"The accounts cannot be read from {self.path}: {error}.") from error
        except ValidationError as error:
            raise ConfigurationError(
                f"{self.path} is no file of accounts ({problem_texts(error.errors(), 'it')[0]}). "
                "Restore it from a copy, or remove it and add the accounts anew with aos-gcs accounts."
            ) from error

    def _write(self, content: _Content) -> None:
        unfinished = self.path.with_name(self.path.name + ".new")
        unfinished.unlink(missing_ok=True)
        descriptor = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _OWNER_ONLY)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump(content.model_dump(mode="json"), file, indent=1)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(self.path)

    def _look(self) -> tuple[int, int, int] | None:
        try:
            found = self.path.stat()
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino

    def _take(self, content: _Content, stamp: tuple[int, int, int] | None) -> None:
        accounts = [Account(one.id, one.name, one.role, one.password, one.created_utc_s) for one in content.accounts]
        self._accounts = {account.name.casefold(): account for account in accounts}
        self._by_id = {account.id: account for account in accounts}
        self._stamp = stamp


def _new_entry(name: str, role: Role, password: str, utc_s: float) -> _Entry:
    _check_role(role)
    try:
        _NAME.validate_python(name)
    except ValidationError as error:
        raise InputDataError("name: 1 to 40 characters, without a slash, and no blanks around it.") from error
    check_password(password, name)
    return _Entry(id=_new_id(), name=name, role=role, password=hash_password(password), created_utc_s=utc_s)


def _add(content: _Content, entry: _Entry) -> None:
    if any(one.name.casefold() == entry.name.casefold() for one in content.accounts):
        raise AccountError(f"There is an account '{entry.name}' already. Take another name, or remove it first.")
    if len(content.accounts) >= MAX_ACCOUNTS:
        raise AccountError(f"There are {MAX_ACCOUNTS} accounts, the largest number. Remove some first.")
    content.accounts.append(entry)


def _check_role(role: Role) -> None:
    if role is Role.VISITOR:
        raise InputDataError("role: observer, analyst, operator or administrator.")


def _new_id() -> str:
    return secrets.token_urlsafe(12)
