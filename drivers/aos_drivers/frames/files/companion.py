"""A companion computer that serves images over HTTP: a listing of a folder, or one address per index."""

from __future__ import annotations

import json
from email.utils import parsedate_to_datetime
from html.parser import HTMLParser
from typing import Any
from urllib.parse import unquote

from yarl import URL

from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.frames.files.matching import FileStamp, Listing, is_image_name
from aos_gcs.errors import CaptureError

_MAX_FILES = 50_000


class CompanionListing:
    """A folder behind a web server that lists it: nginx's autoindex (HTML or JSON), or ``python -m http.server``."""

    def __init__(self, fetcher: ImageFetcher, url: str) -> None:
        """``url`` is the user's, not the vehicle's; only files directly below it are requested."""
        self._fetcher = fetcher
        self._url = URL(url if url.endswith("/") else url + "/")
        self._host = self._url.host or ""

    async def listing(self, deadline_s: float) -> Listing:
        """Return the images that the server lists.

        Raises:
            CaptureError: it cannot be fetched or understood.
        """
        download = await self._fetcher.download(str(self._url), self._host, deadline_s)
        return parse_listing(download.data)

    async def read(self, name: str, deadline_s: float) -> bytes:
        """Return a file of the listing; raises like ``ImageFetcher.download``."""
        if not is_image_name(name):
            raise CaptureError(f"{name!r} is not the name of an image")
        return (await self._fetcher.download(str(self._url / name), self._host, deadline_s)).data


def parse_listing(data: bytes) -> Listing:
    """Return the images of a listing; names that lead out of its folder are none of it.

    Raises:
        CaptureError: it is neither JSON as nginx writes it nor HTML, or lists too much.
    """
    text = data.decode(errors="replace")
    stamps = _parse_json(text) if text.lstrip().startswith("[") else _parse_html(text)
    if len(stamps) > _MAX_FILES:
        raise CaptureError(f"the listing has more than {_MAX_FILES} images: move old ones away")
    return {name: stamp for name, stamp in stamps.items() if is_image_name(name)}


def _parse_json(text: str) -> dict[str, FileStamp]:
    try:
        entries = json.loads(text)
        return dict(_parse_entry(entry) for entry in entries)
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise CaptureError(f"the listing is not a JSON list of names, or of objects with a name: {error}") from error


def _parse_entry(entry: Any) -> tuple[str, FileStamp]:
    if isinstance(entry, str):
        return entry, FileStamp(None, None)
    if not isinstance(entry, dict):
        raise TypeError(f"an entry is {entry!r}")
    size, modified = entry.get("size"), entry.get("mtime")
    modified_utc_s = parsedate_to_datetime(modified).timestamp() if isinstance(modified, str) else None
    return str(entry["name"]), FileStamp(size if isinstance(size, int) else None, modified_utc_s)


class _Links(HTMLParser):
    """Collects where the links of a page lead."""

    def __init__(self) -> None:
        super().__init__()
        self.targets: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "a":
            self.targets += [unquote(value) for name, value in attrs if name == "href" and value]


def _parse_html(text: str) -> dict[str, FileStamp]:
    links = _Links()
    links.feed(text)
    return {target.removeprefix("./"): FileStamp(None, None) for target in links.targets}
