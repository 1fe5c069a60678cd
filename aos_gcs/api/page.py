"""The dashboard's files, or a page with instructions for building them."""

from __future__ import annotations

import asyncio
import os
import re
import stat
from pathlib import Path

from fastapi import FastAPI
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, HTMLResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

STATIC_FOLDER = Path(__file__).parent / "static"

_NOT_BUILT = """<!doctype html><html lang="en"><meta charset="utf-8"><title>aos-gcs: dashboard not built</title>
<body style="font:1.1rem/1.6 system-ui,sans-serif;max-width:40rem;margin:4rem auto;padding:0 1rem">
<h1>The dashboard is not built</h1>
<p>The service is running and its <a href="/api/mission">API</a> works, but the page's files are missing.</p>
<p>Build them once, with Node.js 20.19 or newer, and load this page again:</p>
<pre>cd web &amp;&amp; npm ci &amp;&amp; npm run build</pre></body></html>
"""


_ENCODINGS = {"br": ".br", "gzip": ".gz"}
"""Endings of the compressed forms that the build has written beside its files, by their names in HTTP; best first."""


class _Files(StaticFiles):
    """Files with a rule for browsers' caches, sent compressed where the build has done that and the browser reads it.

    A folder that does not exist (not built) has no files.
    """

    def __init__(self, directory: Path, cache_control: str) -> None:
        super().__init__(directory=directory, check_dir=False)
        self._folder = directory
        self._cache_control = cache_control

    async def check_config(self) -> None:
        if not await asyncio.to_thread(self._folder.is_dir):
            raise HTTPException(status_code=404)

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return the best form of a file that the browser accepts."""
        if not path.endswith(tuple(_ENCODINGS.values())):
            accepted = Headers(scope=scope).get("accept-encoding", "")
            for encoding in _accepted(accepted):
                form, found = await asyncio.to_thread(self._look_up, path + _ENCODINGS[encoding])
                if found is not None and stat.S_ISREG(found.st_mode):
                    response = self.file_response(form, found, scope)
                    response.headers["Content-Encoding"] = encoding
                    response.headers["Vary"] = "Accept-Encoding"
                    return response
        return await super().get_response(path, scope)

    def _look_up(self, path: str) -> tuple[str, os.stat_result | None]:
        try:
            return self.lookup_path(path)
        except (OSError, ValueError):
            return "", None  # no name that a file can have: the plain form is refused with the reason

    def file_response(
        self, full_path: str | os.PathLike[str], stat_result: os.stat_result, scope: Scope, status_code: int = 200
    ) -> Response:
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers["Cache-Control"] = self._cache_control
        return response


def _accepted(accept_encoding: str) -> list[str]:
    """Return the encodings of ours that a browser reads, best first; what it refuses has the weight 0."""
    weights = {}
    for part in accept_encoding.lower().split(","):
        name, _, parameters = part.partition(";")
        weights[name.strip()] = parameters.replace(" ", "")
    refused = re.compile(r"q=0(\.0*)?")
    return [one for one in _ENCODINGS if one in weights and not refused.fullmatch(weights[one])]


def add_page(app: FastAPI, static_folder: Path | None = None) -> None:
    """Serve the dashboard at ``/``. To be called last: it takes all paths that nothing else has taken.

    Args:
        app: the application.
        static_folder: the dashboard's build; by default the one inside the package.
    """
    folder = static_folder or STATIC_FOLDER
    index = folder / "index.html"

    @app.get("/", include_in_schema=False)
    def read_index() -> Response:
        if not index.is_file():
            return HTMLResponse(_NOT_BUILT, status_code=503, headers={"Cache-Control": "no-store"})
        return FileResponse(index, headers={"Cache-Control": "no-cache"})

    app.mount("/assets", _Files(folder / "assets", cache_control="public, max-age=31536000, immutable"))
    app.mount("/", _Files(folder, cache_control="no-cache"))
