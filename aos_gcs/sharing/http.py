"""Requests to the services of others: bounded in time and size, and failures in words."""

from __future__ import annotations

import ssl
from collections.abc import Mapping
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from typing import Final, Protocol

import aiohttp

from aos_gcs.errors import ConfigurationError
from aos_gcs.sharing.channel import ChannelError

TIMEOUT_S: Final = 10.0
"""Longest time for a request with its answer."""
MAX_ANSWER_BYTES: Final = 16 * 2**20
"""Largest answer, such as all objects of a map."""
_REFUSALS: Final = frozenset({401, 403, 404, 405, 410})


@dataclass(frozen=True, slots=True)
class Request:
    """One request."""

    method: str
    url: str
    body: bytes | None = None
    headers: Mapping[str, str] | None = None
    timeout_s: float = TIMEOUT_S


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer to a request, whatever its status."""

    status: int
    body: bytes
    date_utc_s: float | None = None
    """Time by the clock of the service, where it tells."""

    @property
    def is_success(self) -> bool:
        """Whether the request was carried out."""
        return 200 <= self.status < 300

    def error(self, remedy: str) -> ChannelError:
        """Return what an unsuccessful answer means.

        Args:
            remedy: what to check when the service refuses us, as an imperative clause.
        """
        if 300 <= self.status < 400:
            return ChannelError(f"The service has moved ({self.status}); {remedy}.", is_refused=True)
        if self.status in _REFUSALS:
            return ChannelError(f"The service refuses us ({self.status}); {remedy}.", is_refused=True)
        return ChannelError(f"The service answers with status {self.status}.")


def https_context(field: str, ca_file: str | None) -> ssl.SSLContext:
    """Return the certificates by which services are verified.

    Args:
        field: field of the configuration that names the file.
        ca_file: PEM file of certificates; None: those of the system.

    Raises:
        ConfigurationError: the file cannot be used.
    """
    try:
        return ssl.create_default_context(cafile=ca_file)
    except OSError as error:
        raise ConfigurationError(f"{field}: {ca_file} is not a PEM file of certificates.") from error


class Requests(Protocol):
    """Makes requests."""

    async def request(self, request: Request) -> Answer:
        """Make a request; see :class:`Client`."""
        ...

    async def close(self) -> None:
        """Close the connections."""
        ...


class Client:
    """Makes requests, one connection at a time, and follows nobody elsewhere.

    Args:
        context: certificates by which services are verified.
    """

    def __init__(self, context: ssl.SSLContext) -> None:
        self._context = context
        self._session: aiohttp.ClientSession | None = None

    async def request(self, request: Request) -> Answer:
        """Make a request.

        Raises:
            ChannelError: there is no answer.
        """
        if self._session is None:
            self._session = aiohttp.ClientSession(cookie_jar=aiohttp.DummyCookieJar())
        try:
            async with self._session.request(
                request.method,
                request.url,
                data=request.body,
                headers=request.headers,
                allow_redirects=False,
                ssl=self._context,
                timeout=aiohttp.ClientTimeout(total=request.timeout_s),
            ) as answer:
                return Answer(answer.status, await _read(answer), _date(answer.headers.get("Date", "")))
        except TimeoutError:
            text = f"No answer within {request.timeout_s:.0f} s; check the address and the network."
            raise ChannelError(text) from None
        except aiohttp.ClientConnectorCertificateError as error:
            text = f"The service's certificate cannot be verified ({error.certificate_error})."
            raise ChannelError(text, is_refused=True) from None
        except aiohttp.ClientConnectorDNSError:
            raise ChannelError("The name of the service is not known; check it, or the network.") from None
        except (aiohttp.ClientError, OSError) as error:
            # Texts of these errors may hold the URL, and that may hold what is secret.
            raise ChannelError(f"No connection to the service ({type(error).__name__}).") from None

    async def close(self) -> None:
        """Close the connections."""
        if self._session is not None:
            await self._session.close()


def _date(text: str) -> float | None:
    try:
        return parsedate_to_datetime(text).timestamp()
    except ValueError:
        return None


async def _read(answer: aiohttp.ClientResponse) -> bytes:
    """Return the body of an answer.

    Raises:
        ChannelError: it is too large.
    """
    body = bytearray()
    async for part in answer.content.iter_any():
        body += part
        if len(body) > MAX_ANSWER_BYTES:
            raise ChannelError(f"The service's answer is larger than {MAX_ANSWER_BYTES // 2**20} MiB.")
    return bytes(body)
