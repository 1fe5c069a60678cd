"""Limit on the size of requests, which are refused before they fill the memory."""

from __future__ import annotations

from collections.abc import Collection
from http import HTTPStatus
from typing import Final

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from aos_gcs.api.errors import error_response

MAX_BODY_BYTES: Final = 1024 * 1024
"""Several times the largest plan."""
_TEXT = f"The request is larger than the limit of {MAX_BODY_BYTES // 1024} KiB."


class BodyLimitMiddleware:
    """Answers 413 to requests with a body that is too large.

    Args:
        app: to protect.
        streaming_paths: paths of the routes that read bodies piece by piece, with a limit of their own.
    """

    def __init__(self, app: ASGIApp, streaming_paths: Collection[str] = ()) -> None:
        self._app = app
        self._streaming_paths = frozenset(streaming_paths)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check what is announced, then count what comes."""
        if scope["type"] != "http" or scope["path"] in self._streaming_paths:
            await self._app(scope, receive, send)
            return
        announced = Headers(scope=scope).get("content-length", "0")
        if not announced.isdecimal() or int(announced) > MAX_BODY_BYTES:
            await error_response(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "too_large", _TEXT)(scope, receive, send)
            return
        received = 0

        async def receive_some() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > MAX_BODY_BYTES:
                raise HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, _TEXT)
            return message

        await self._app(scope, receive_some, send)
