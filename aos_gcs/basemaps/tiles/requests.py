"""Requests to a tile server: few at a time, slowed down when it asks for it, and failures in words without addresses.

Sources: RFC 9110, 10.2.3 (Retry-After) and 15.4 (redirection).
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from http import HTTPStatus
from importlib.metadata import version
from typing import Final
from urllib.parse import urljoin

import aiohttp

from aos_gcs.basemaps.tiles.addresses import TileTemplate, origin
from aos_gcs.errors import ConfigurationError, InputDataError, LinkError

CONNECTIONS: Final = 2
MAX_TILE_BYTES: Final = 1024 * 1024
MAX_WAIT_S: Final = 600.0
"""Longest time that a server may ask to be left alone; beyond it the download ends."""
_TRIES: Final = 5
_FIRST_WAIT_S: Final = 2.0
"""Time without requests after a failure; it doubles with each further one of the same tile."""
_TIMEOUT: Final = aiohttp.ClientTimeout(total=60.0, sock_connect=15.0)
_MAX_REDIRECTS: Final = 3
_EMPTY: Final = frozenset({HTTPStatus.NO_CONTENT, HTTPStatus.NOT_FOUND})
_PASSING: Final = frozenset({408, 425, 429, 500, 502, 503, 504})
"""Statuses after which the same request may succeed later."""
_KEPT: Final = "the same command goes on where this one ended"


@dataclass(frozen=True, slots=True)
class _Answer:
    status: int
    body: bytes = b""
    wait_s: float | None = None
    """Time for which the server asks to be left alone, in seconds."""
    location: str = ""


class Pace:
    """Times at which requests may be sent: so many per second, none while the server is left alone.

    Args:
        per_s: greatest number of requests per second.
        now: clock in seconds; None: that of the running loop.
        sleep: function that waits for a number of seconds.
    """

    def __init__(
        self,
        per_s: float,
        now: Callable[[], float] | None = None,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._interval_s = 1.0 / per_s
        self._clock, self._sleep = now, sleep
        self._next_s = 0.0

    async def turn(self) -> None:
        """Wait until the next request may be sent, and count it."""
        while (wait_s := self._next_s - self._now()) > 0.0:
            await self._sleep(wait_s)
        self._next_s = self._now() + self._interval_s

    def leave_alone(self, wait_s: float) -> None:
        """Send nothing for a number of seconds."""
        self._next_s = max(self._next_s, self._now() + wait_s)

    def _now(self) -> float:
        return asyncio.get_running_loop().time() if self._clock is None else self._clock()


def tile_session() -> aiohttp.ClientSession:
    """Return a session without cookies, whose requests name the program and its version."""
    return aiohttp.ClientSession(
        connector=aiohttp.TCPConnector(limit=CONNECTIONS),
        cookie_jar=aiohttp.DummyCookieJar(),
        auto_decompress=False,
        headers={
            "User-Agent": f"aos-gcs/{version('aos-gcs')} (aos-gcs basemap)",
            "Accept": "image/webp,image/png,image/jpeg",
            "Accept-Encoding": "identity",
        },
        timeout=_TIMEOUT,
    )


class TileRequests:
    """Requests for the tiles of one server."""

    def __init__(self, template: TileTemplate, session: aiohttp.ClientSession, pace: Pace) -> None:
        self._template, self._session, self._pace = template, session, pace

    async def tile(self, zoom: int, column: int, row: int) -> bytes:
        """Return a tile as the server sends it; nothing where it has none.

        Raises:
            ConfigurationError: the server refuses it, or leads elsewhere.
            InputDataError: it is too large.
            LinkError: there is no answer, or none but failures.
        """
        name = f"tile {zoom}/{column}/{row}"
        address = self._template.address(zoom, column, row)
        reason = ""
        for attempt in range(_TRIES):
            asked_s: float | None = None
            try:
                answer = await self._answer(address, name)
            except TimeoutError:
                reason = "no answer in time"
            except aiohttp.ClientSSLError as error:
                raise LinkError(
                    f"{self._template.host}: its certificate cannot be verified ({type(error).__name__}); check the "
                    "host in --tiles, and the clock of this computer."
                ) from None
            except (aiohttp.ClientError, OSError) as error:
                # Texts of these errors may hold the address, and that may hold a key.
                reason = f"no connection ({type(error).__name__})"
            else:
                if answer.status not in _PASSING:
                    return self._content(answer, name)
                reason, asked_s = f"status {answer.status}", answer.wait_s
            self._wait(asked_s, attempt)
        raise LinkError(
            f"{self._template.host}: {name}: {reason}, {_TRIES} times; check the network and the server: {_KEPT}."
        )

    def _wait(self, asked_s: float | None, attempt: int) -> None:
        """Leave the server alone for as long as it asks for, else longer after each failure."""
        if asked_s is not None and asked_s > MAX_WAIT_S:
            raise LinkError(
                f"{self._template.host} asks for no requests for {asked_s:,.0f} s; come back after that: {_KEPT}."
            )
        self._pace.leave_alone(max(asked_s or 0.0, _FIRST_WAIT_S * 2**attempt))

    def _content(self, answer: _Answer, name: str) -> bytes:
        if answer.status in _EMPTY:
            return b""
        if answer.status != HTTPStatus.OK:
            raise ConfigurationError(
                f"{self._template.host} refuses {name} (status {answer.status}): check the address in --tiles, its "
                "key, the zooms, and the terms of the server."
            )
        return answer.body

    async def _answer(self, address: str, name: str) -> _Answer:
        """Return the answer at an address, or at another of the same server to which that one leads."""
        for _ in range(_MAX_REDIRECTS):
            answer = await self._asked(address, name)
            if not answer.location:
                return answer
            elsewhere, place = _destination(address, answer.location)
            if place is None or place != origin(address):
                named = "no address of HTTP" if place is None else place[1]
                raise ConfigurationError(
                    f"{self._template.host}: {name}: the server leads to another scheme, host or port ({named}), which "
                    "is not followed: give --tiles that address if its terms allow copies."
                )
            address = elsewhere
        raise ConfigurationError(f"{self._template.host}: {name}: more than {_MAX_REDIRECTS} redirections.")

    async def _asked(self, address: str, name: str) -> _Answer:
        await self._pace.turn()
        async with self._session.get(address, allow_redirects=False) as answer:
            if HTTPStatus.MULTIPLE_CHOICES <= answer.status < HTTPStatus.BAD_REQUEST:
                return _Answer(answer.status, location=answer.headers.get("Location", ""))
            if answer.status != HTTPStatus.OK:
                return _Answer(answer.status, wait_s=_wait_s(answer))
            body = bytearray()
            async for part in answer.content.iter_any():
                body += part
                if len(body) > MAX_TILE_BYTES:
                    raise InputDataError(
                        f"{self._template.host}: {name} is larger than {MAX_TILE_BYTES // 1024} KiB: check the address "
                        "in --tiles."
                    )
            return _Answer(answer.status, bytes(body))


def _destination(address: str, location: str) -> tuple[str, tuple[str, str, int] | None]:
    """Return where a redirection leads, with its scheme, host and port; None for what is no address of HTTP."""
    try:
        elsewhere = urljoin(address, location)
        return elsewhere, origin(elsewhere)
    except ValueError:
        return location, None


def _wait_s(answer: aiohttp.ClientResponse) -> float | None:
    """Return for how long a server asks to be left alone: seconds, or until a time of its own clock."""
    text = answer.headers.get("Retry-After", "").strip()
    if text.isascii() and text.isdigit():
        return float(text[:9])
    try:
        until, now = (parsedate_to_datetime(one) for one in (text, answer.headers.get("Date", "")))
        return max(0.0, until.timestamp() - now.timestamp())
    except ValueError:
        return None
