"""Operators, who have signed in with the service's code and may send commands, and observers, who may not.

The code is exchanged once for a cookie, so that only one request contains it. Sessions outlast a restart of the service
where it has a file for them; another code ends them.
"""

from __future__ import annotations

import asyncio
import hmac
import math
import secrets
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from starlette.requests import HTTPConnection

from aos_gcs.api.access.guess_throttle import GuessThrottle, group_of
from aos_gcs.api.access.operator_file import OperatorFile, digest
from aos_gcs.errors import AosError

MAX_OPERATORS: Final = 32
"""Largest number of operators signed in at a time; another one replaces the earliest."""

MAX_ADDRESSES: Final = 64
"""Largest number of operators' addresses that are remembered."""
_WRITTEN_WITHIN_S: Final = 1.0
"""Time for which a sign-in waits for the disk."""


class AccessDeniedError(AosError):
    """A request that only operators may make."""


class ObserverError(AccessDeniedError):
    """A command of an observer."""

    def __init__(self, text: str = "Observers cannot send commands. Sign in with the operator code.") -> None:
        super().__init__(text)


class WrongCodeError(AccessDeniedError):
    """A wrong operator code."""


class TooManyGuessesError(AccessDeniedError):
    """Too many wrong codes; this one was not compared."""

    def __init__(self, text: str, retry_after_s: int = 1) -> None:
        super().__init__(text)
        self.retry_after_s = retry_after_s


class Role(StrEnum):
    """Role of a client."""

    OPERATOR = "operator"
    OBSERVER = "observer"


@dataclass(frozen=True, slots=True)
class Session:
    """Role and name of a client."""

    role: Role
    name: str
    """Name given at sign-in; empty for observers."""


OBSERVER: Final = Session(Role.OBSERVER, "")
_UNNAMED_OPERATOR: Final = Session(Role.OPERATOR, "")


class Access:
    """The operators who are signed in.

    Args:
        operator_code: code for signing in; None: no sign-in, every client is an operator.
        now_s: clock in real seconds, for the wait after wrong codes.
        file: remembers who is signed in; None: sessions last as long as the service.
    """

    def __init__(self, operator_code: str | None, now_s: Callable[[], float], file: OperatorFile | None = None) -> None:
        self._code = operator_code
        self._throttle = GuessThrottle(now_s)
        self._file = file
        known = {} if file is None or operator_code is None else file.sessions(operator_code)
        self._sessions = {token_digest: Session(Role.OPERATOR, name) for token_digest, name in known.items()}
        """Sessions by the digests of their tokens, which are kept nowhere."""
        noted = () if file is None or operator_code is None else file.addresses(operator_code)
        self._addresses = {group_of(address): address for address in noted}
        """Addresses of operators by the group that counts as one, the latest last."""

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
        return self._code is not None

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
        wait_s = math.ceil(self._throttle.wait_s(address))
        if wait_s > 0:
            remedy = f"Wait {wait_s} s, then sign in with the code that the service printed when it started."
            raise TooManyGuessesError(f"Too many wrong codes. {remedy}", wait_s)
        if self._code is None or not hmac.compare_digest(code.encode(), self._code.encode()):
            self._throttle.note_wrong(address)
            raise WrongCodeError("Wrong operator code. The service printed the code when it started.")
        self._throttle.note_right(address)
        if len(self._sessions) >= MAX_OPERATORS:
            del self._sessions[next(iter(self._sessions))]
        token = secrets.token_urlsafe(32)
        self._sessions[digest(token)] = Session(Role.OPERATOR, name)
        return token

    def sign_out(self, token: str | None) -> None:
        """End a session; nothing happens if there is none."""
        self._sessions.pop(digest(token or ""), None)

    async def write_down(self) -> None:
        """Remember who is signed in, and where; a disk that hangs keeps nobody from it."""
        if self._file is None or self._code is None:
            return
        names = {token_digest: session.name for token_digest, session in self._sessions.items()}
        with suppress(TimeoutError):
            async with asyncio.timeout(_WRITTEN_WITHIN_S):
                await asyncio.to_thread(self._file.keep, self._code, names, self.addresses)

    def session(self, token: str | None) -> Session:
        """Return the session behind a token."""
        if self._code is None:
            return _UNNAMED_OPERATOR
        return self._sessions.get(digest(token or ""), OBSERVER)

    def session_of(self, connection: HTTPConnection) -> Session:
        """Return the session of a request or WebSocket."""
        return self.session(connection.cookies.get(cookie_name(connection)))


def cookie_name(connection: HTTPConnection) -> str:
    """Return the cookie's name. Browsers share cookies between the ports of a host, services must not."""
    return f"aos_gcs_{connection.url.port or 80}"
