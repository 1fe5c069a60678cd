"""The dashboard's files, or a page with instructions for building them."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path

from fastapi import FastAPI
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


class _Files(StaticFiles):
    """Files with a rule for browsers' caches. A folder that does not exist (not built) has no files."""

    def __init__(self, directory: Path, cache_control: str) -> None:
        super().__init__(directory=directory, check_dir=False)
        self._folder = directory
        self._cache_control = cache_control

    async def check_config(self) -> None:
        if not await asyncio.to_thread(self._folder.is_dir):
            raise HTTPException(status_code=404)

    def file_response(
        self, full_path: str | os.PathLike[str], stat_result: os.stat_result, scope: Scope, status_code: int = 200
    ) -> Response:
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers["Cache-Control"] = self._cache_control
        return response


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
