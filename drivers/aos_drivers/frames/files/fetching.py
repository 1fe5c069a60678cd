"""Fetching images from a camera's web server."""

from __future__ import annotations

import ipaddress
from collections.abc import Callable
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from functools import partial
from typing import TypeVar

import aiohttp
from yarl import URL

from aos_drivers.frames.errors import LateFrameError, PendingImageError, TornFrameError
from aos_drivers.frames.files.images import MAX_PIXELS, Image, decode_image
from aos_gcs.errors import CaptureError, WorkerError
from aos_gcs.ports import Clock, ThreadWorker, Worker

T = TypeVar("T")

_CHUNK_BYTES = 64 * 1024
_IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
_FIRST_USERS_PORT = 1024
"""Ports below are those of the system's own services."""
_REMEDY = "list its host in the option image_hosts if that is intended"
_NOT_THERE = frozenset({404, 410, 425, 503})
"""Answers of a server that may have the file a moment later."""


@dataclass(frozen=True, slots=True)
class ImageLimits:
    """Largest files and images; larger ones are refused before they are decoded."""

    max_bytes: int = 64 * 2**20
    """Size of a file."""
    max_pixels: int = MAX_PIXELS
    """Pixels of all pages of an image together."""


@dataclass(frozen=True, slots=True)
class Download:
    """A file that was fetched."""

    data: bytes
    age_s: float | None
    """Age of the file by the server's own clock; None if the server does not report it."""


class ImageFetcher:
    """Downloads and decodes images over one shared HTTP session."""

    def __init__(
        self,
        session: aiohttp.ClientSession,
        clock: Clock,
        limits: ImageLimits,
        allowed_hosts: tuple[str, ...],
        decoding: Worker | None = None,
    ) -> None:
        """Fetch within ``limits``, from a vehicle's own host or one of ``allowed_hosts``.

        Files are decoded by ``decoding``; None: in threads of this process.
        """
        self._session = session
        self._clock = clock
        self.limits = limits
        self._allowed_hosts = allowed_hosts
        self._decoding = decoding or ThreadWorker()

    async def fetch(self, url_text: str, vehicle_host: str, deadline_s: float) -> tuple[Image, tuple[str, ...]]:
        """Return image and bands, as :func:`decode_image` does, of a file that the vehicle at ``vehicle_host`` names.

        Raises:
            CaptureError: the address is not allowed, or the file is too large, damaged or late.
        """
        url = self._checked(url_text, vehicle_host)
        is_here = _is_loopback(vehicle_host) and url.host not in self._allowed_hosts
        if is_here and not _names_an_image(url):
            raise CaptureError(
                f"the image address {url_text!r} is on this machine and does not name a file of an image: {_REMEDY}"
            )
        download = await self.download(url_text, vehicle_host, deadline_s)
        read = partial(decode_image, max_pixels=self.limits.max_pixels)
        try:
            async with self._clock.timeout_at(deadline_s):
                return await self.decode(read, download.data)
        except TimeoutError:
            raise LateFrameError(f"{url_text} was not decoded in time") from None

    async def decode(self, read: Callable[[bytes], T], data: bytes) -> T:
        """Return what ``read``, a function that another process can import, makes of a file.

        Raises:
            CaptureError: of ``read``, or because decoding took too much time or memory.
        """
        try:
            return await self._decoding.run(read, data)
        except WorkerError as error:
            raise CaptureError(f"its image of {len(data)} bytes cannot be decoded: {error}") from error

    async def download(self, url_text: str, vehicle_host: str, deadline_s: float) -> Download:
        """Return a file that the vehicle at ``vehicle_host`` names, as it is.

        Raises:
            PendingImageError: the server does not have it, or not yet.
            TornFrameError: the transfer ended before the file did.
            LateFrameError: it did not arrive by the deadline.
            CaptureError: the address is not allowed, the file is too large, or the server answers with something else.
        """
        url = self._checked(url_text, vehicle_host)
        try:
            async with self._clock.timeout_at(deadline_s):
                return await self._download(url)
        except TimeoutError:
            raise LateFrameError(f"{url_text} did not arrive in time") from None
        except aiohttp.ClientPayloadError as error:
            raise TornFrameError(f"{url_text} cannot be fetched whole: {error}") from error
        except aiohttp.ClientError as error:
            raise CaptureError(f"{url_text} cannot be fetched: {error}") from error

    def _checked(self, url_text: str, vehicle_host: str) -> URL:
        if not url_text:
            raise CaptureError("the camera gives no address of its image: it has no file server")
        try:
            url = URL(url_text)
        except ValueError as error:
            raise CaptureError(f"the image address {url_text!r} cannot be understood") from error
        if url.scheme not in ("http", "https") or not url.host:
            raise CaptureError(f"the image address {url_text!r} is not http or https")
        if url.host in self._allowed_hosts:
            return url
        if not _is_same_host(url.host, vehicle_host):
            raise CaptureError(
                f"the image address {url_text!r} is not on the vehicle's own host {vehicle_host}: {_REMEDY}"
            )
        return url

    async def _download(self, url: URL) -> Download:
        # Compressed transfers are refused: their size is not that of their contents.
        headers = {"Accept-Encoding": "identity"}
        async with self._session.get(url, allow_redirects=False, headers=headers) as response:
            if response.status in _NOT_THERE:
                raise PendingImageError(f"{url} answers with HTTP status {response.status}")
            if response.status != 200:
                raise CaptureError(f"{url} answers with HTTP status {response.status}")
            if response.headers.get("Content-Encoding", "identity") != "identity":
                raise CaptureError(f"{url} is compressed for the transfer: switch that off in the server")
            data = bytearray()
            async for chunk in response.content.iter_chunked(_CHUNK_BYTES):
                data += chunk
                if len(data) > self.limits.max_bytes:
                    raise CaptureError(f"{url} is larger than {self.limits.max_bytes / 2**20:.0f} MiB (max_image_mib)")
            return Download(bytes(data), _age_s(response.headers.get("Date"), response.headers.get("Last-Modified")))


def _age_s(date: str | None, last_modified: str | None) -> float | None:
    if date is None or last_modified is None:
        return None
    try:
        return (parsedate_to_datetime(date) - parsedate_to_datetime(last_modified)).total_seconds()
    except (TypeError, ValueError):
        return None


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _names_an_image(url: URL) -> bool:
    """Return whether an address can only be that of a file: the station's own machine has services of other kinds.

    A vehicle is heard from this machine through a router or a simulator.
    """
    is_plain = not (url.raw_query_string or url.raw_fragment or url.user or url.password)
    port = url.port or 0
    return is_plain and port >= _FIRST_USERS_PORT and url.path.lower().endswith(_IMAGE_SUFFIXES)


def _is_same_host(host: str, vehicle_host: str) -> bool:
    """Compare addresses; names are not resolved, as their answer could change between check and use."""
    try:
        vehicle = ipaddress.ip_address(vehicle_host)
        return vehicle.is_loopback if host == "localhost" else ipaddress.ip_address(host) == vehicle
    except ValueError:
        return host == vehicle_host
