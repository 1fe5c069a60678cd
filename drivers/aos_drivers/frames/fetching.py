"""Fetching images from a camera's web server."""

from __future__ import annotations

import asyncio
import ipaddress

import aiohttp
from yarl import URL

from aos_drivers.frames.images import Image, decode_image
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Clock

_CHUNK_BYTES = 64 * 1024


class ImageFetcher:
    """Downloads and decodes images over one shared HTTP session."""

    def __init__(
        self, session: aiohttp.ClientSession, clock: Clock, max_bytes: int, allowed_hosts: tuple[str, ...]
    ) -> None:
        """Fetch at most ``max_bytes`` per image, from a vehicle's own host or one of ``allowed_hosts``."""
        self._session = session
        self._clock = clock
        self._max_bytes = max_bytes
        self._allowed_hosts = allowed_hosts

    async def fetch(self, url_text: str, vehicle_host: str, deadline_s: float) -> tuple[Image, tuple[str, ...]]:
        """Return image and bands, as :func:`decode_image` does, of a file that the vehicle at ``vehicle_host`` names.

        Raises:
            CaptureError: the address is not allowed, or the file is too large, damaged or late.
        """
        url = self._checked(url_text, vehicle_host)
        try:
            async with self._clock.timeout_at(deadline_s):
                data = await self._download(url)
                return await asyncio.to_thread(decode_image, data)
        except TimeoutError:
            raise CaptureError(f"{url_text} did not arrive in time") from None
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
        if not _is_same_host(url.host, vehicle_host) and url.host not in self._allowed_hosts:
            raise CaptureError(
                f"the image address {url_text!r} is not on the vehicle's own host {vehicle_host}: "
                "list its host in the option image_hosts if that is intended"
            )
        return url

    async def _download(self, url: URL) -> bytes:
        async with self._session.get(url, allow_redirects=False) as response:
            if response.status != 200:
                raise CaptureError(f"{url} answers with HTTP status {response.status}")
            data = bytearray()
            async for chunk in response.content.iter_chunked(_CHUNK_BYTES):
                data += chunk
                if len(data) > self._max_bytes:
                    raise CaptureError(f"{url} is larger than {self._max_bytes / 2**20:.0f} MiB (max_image_mib)")
            return bytes(data)


def _is_same_host(host: str, vehicle_host: str) -> bool:
    """Compare addresses; names are not resolved, as their answer could change between check and use."""
    try:
        vehicle = ipaddress.ip_address(vehicle_host)
        return vehicle.is_loopback if host == "localhost" else ipaddress.ip_address(host) == vehicle
    except ValueError:
        return host == vehicle_host
