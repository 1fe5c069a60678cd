"""Sign-ins and sessions: of operators with the service's code, or of everybody with an account.

Code and password are exchanged once for a cookie, so that only one request contains them. Sessions outlast a restart of
the service where it has a file for them; another code ends them, and so does another password that of its account.
"""

from __future__ import annotations

import asyncio
import hmac
import math
import secrets
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Final

from starlette.requests import HTTPConnection

from aos_gcs.api.access.account_sessions import AccountSessions
from aos_gcs.api.access.accounts import Account, AccountFile
from aos_gcs.api.access.control import Control
from aos_gcs.api.access.guess_throttle import GuessThrottle, group_of
from aos_gcs.api.access.operator_file import OperatorFile, digest
from aos_gcs.api.access.roles import Role, Session
from aos_gcs.errors import AosError

MAX_OPERATORS: Final = 32
"""Largest number of operators signed in at a time; another one replaces the earliest."""

MAX_ADDRESSES: Final = 64
"""Largest number of operators' addresses that are remembered."""
_OF_ACCOUNTS: Final = "accounts"
_WRITTEN_WITHIN_S: Final = 1.0
"""Time for which a sign-in waits for the disk."""


class AccessDeniedError(AosError):
    """A request that only operators may make."""


class ObserverError(AccessDeniedError):
    """A command of an observer."""

    def __init__(self, text: str = "Observers cannot send commands. Sign in with the operator code.") -> None:
        super().__init__(text)


class RoleError(AccessDeniedError):
    """A request that needs another role than the account has."""


class SignInRequiredError(AccessDeniedError):
    """A request of somebody who has not signed in, where everybody has an account."""

    def __init__(self, text: str = "Sign in with your account first.") -> None:
        super().__init__(text)


class WrongCodeError(AccessDeniedError):
    """A wrong operator code, or a wrong password."""


class TooManyGuessesError(AccessDeniedError):
    """Too many wrong codes; this one was not compared."""

    def __init__(self, text: str, retry_after_s: int = 1) -> None:
        super().__init__(text)
        self.retry_after_s = retry_after_s


OBSERVER: Final = Session(Role.OBSERVER, "")
VISITOR: Final = Session(Role.VISITOR, "")
_UNNAMED_OPERATOR: Final = Session(Role.OPERATOR, "")


class Access:
    """Operators who are signed in.

    Args:
        operator_code: code for signing in; None: no sign-in, every client is an operator.
        now_s: clock in real seconds, for the wait after wrong codes.
        file: remembers who is signed in; None: sessions last as long as the service.
        accounts: accounts of everybody, in the place of the code.
        anyone_observes: with accounts, those who have not signed in observe.
    """

    def __init__(
        self,
        operator_code: str | None,
        now_s: Callable[[], float],
        file: OperatorFile | None = None,
        accounts: AccountFile | None = None,
        *,
        anyone_observes: bool = False,
    ) -> None:
        self._code = operator_code if accounts is None else None
        self._key = self._code if accounts is None else _OF_ACCOUNTS
        """What the sessions in the file are valid for."""
        self._file = file
        known = {} if file is None or self._key is None else file.sessions(self._key)
        self.accounts = None if accounts is None else AccountSessions(accounts, known, now_s)
        self._stranger = VISITOR if accounts is not None and not anyone_observes else OBSERVER
        self._sessions = (
            {} if accounts is not None else {key: Session(Role.OPERATOR, name) for key, name in known.items()}
        )
        """Sessions by the digests of their tokens, which are kept nowhere."""
        noted = () if file is None or self._key is None else file.addresses(self._key)
        self._addresses = {group_of(address): address for address in noted}
        """Addresses of operators by the group that counts as one, the latest last."""
        holder = None if file is None or self._key is None else file.control(self._key)
        self.control = Control(now_s, holder)
        self._throttle = GuessThrottle(now_s, is_known=lambda address: group_of(address) in self._addresses)

    @property
    def addresses(self) -> tuple[str, ...]:
        """Addresses that operators have sent requests from, also before the process was replaced."""
        return tuple(self._addresses.values())

    def note_address(self, address: str) -> bool:
        """Note that an operator is at this address; return whether that is new, and has to be written down."""
        if (group := group_of(address)) in self._addresses:
            return False
        if len(self._addresses) >= MAX_ADDRESSES:
            del self._addresses[next(iter(self._addresses))]
        self._addresses[group] = address
        return True

    @property
    def is_required(self) -> bool:
        """Whether commands require a sign-in."""
        return self._key is not None

    def sign_in(self, code: str, name: str, address: str) -> str:
        """Return the token of a new operator's session.

        Args:
            code: code that was entered.
            name: name of the person.
            address: source address of the request.

        Raises:
            TooManyGuessesError: too many wrong codes; this one was not compared.
            WrongCodeError: the code is not the service's.
        """
        self._check_wait(address, "codes", "sign in with the code that the service printed when it started")
        if self._code is None or not hmac.compare_digest(code.encode(), self._code.encode()):
            self._throttle.note_wrong(address)
            raise WrongCodeError("Wrong operator code. The service printed the code when it started.")
        self._throttle.note_right(address)
        if len(self._sessions) >= MAX_OPERATORS:
            del self._sessions[next(iter(self._sessions))]
        token = secrets.token_urlsafe(32)
        self._sessions[digest(token)] = Session(Role.OPERATOR, name)
        return token

    async def sign_in_by(self, account: Callable[[], Awaitable[Account | None]], address: str, about: str = "") -> str:
        """Return the token of a session of the account that a password or an invitation leads to.

        Args:
            account: returns the account; None where name, password or invitation are wrong.
            address: source address of the request.
            about: name of the account; nothing for invitations.

        Raises:
            TooManyGuessesError: too many wrong passwords; this one was not compared.
            WrongCodeError: no account was found.
        """
        if self.accounts is None:
            raise WrongCodeError("This service has no accounts. Sign in with the operator code.")
        self._check_wait(address, "passwords", "sign in again")
        # Counted before it is compared: comparing takes a while, in which many more could come.
        self._throttle.note_wrong(address, about)
        found = await account()
        if found is None:
            raise WrongCodeError("Wrong name or password.")
        self._throttle.note_right(address, about)
        return self.accounts.begin(found)

    def _check_wait(self, address: str, what: str, remedy: str) -> None:
        wait_s = math.ceil(self._throttle.wait_s(address))
        if wait_s > 0:
            raise TooManyGuessesError(f"Too many wrong {what}. Wait {wait_s} s, then {remedy}.", wait_s)

    def sign_out(self, token: str | None) -> None:
        """End a session; nothing happens if there is none."""
        self._sessions.pop(digest(token or ""), None)
        if self.accounts is not None:
            self.accounts.end(token or "")

    async def write_down(self) -> None:
        """Remember who is signed in, and where; a disk that hangs keeps nobody from it."""
        if self._file is None or self._key is None:
            return
        names = {token_digest: session.name for token_digest, session in self._sessions.items()}
        if self.accounts is not None:
            names = self.accounts.to_keep()
        with suppress(TimeoutError):
            async with asyncio.timeout(_WRITTEN_WITHIN_S):
                await asyncio.to_thread(self._file.keep, self._key, names, self.addresses, self.control.holder)

    def session(self, token: str | None) -> Session:
        """Return the session behind a token."""
        if self._key is None:
            return _UNNAMED_OPERATOR
        if self.accounts is not None:
            return self.accounts.session(token or "") or self._stranger
        return self._sessions.get(digest(token or ""), OBSERVER)

    def session_of(self, connection: HTTPConnection) -> Session:
        """Return the session of a request or WebSocket."""
        return self.session(connection.cookies.get(cookie_name(connection)))

    def check(self, session: Session, needed: Role) -> None:
        """Refuse a request for which a role is not enough.

        Raises:
            SignInRequiredError: an account is needed.
            ObserverError: the operator code is needed.
            RoleError: the account has another role.
        """
        if session.role.may(needed):
            return
        if self.accounts is None:
            raise ObserverError()
        if not session.name:
            raise SignInRequiredError()
        raise RoleError(f"This needs the role {needed}; you are signed in as {session.role}. Ask an administrator.")


def cookie_name(connection: HTTPConnection) -> str:
    """Return the cookie's name. Browsers share cookies between the ports of a host, services must not."""
    return f"aos_gcs_{connection.url.port or 80}"
