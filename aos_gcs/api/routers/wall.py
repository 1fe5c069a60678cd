"""Live pictures: one WebSocket per viewer for all tiles that it watches."""

from __future__ import annotations

import asyncio
from typing import Final, NoReturn

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from aos_gcs.api.access.peer_limits import WALL_PATH
from aos_gcs.api.access.roles import Role
from aos_gcs.api.convert.wall import WallMessages
from aos_gcs.api.dependencies import session_of, wall_messages_of, wall_of
from aos_gcs.api.models.wall import WALL_CLIENT_MESSAGE, WallAnswer, WallRequest
from aos_gcs.errors import InputDataError
from aos_gcs.input_values import problem_texts
from aos_gcs.wall.model import TileName
from aos_gcs.wall.watch import Watch

router = APIRouter()

SEND_TIMEOUT_S: Final = 10.0
"""Time after which a viewer that accepts no data is disconnected."""
ANSWER_TIMEOUT_S: Final = 15.0
"""Time after which a viewer is disconnected that has not said that it has shown what it was sent."""
_POLICY: Final = 1008
"""Code of connections that are refused, or whose session has ended."""
_GONE: Final = 1006
"""Code of connections that have ended without a word."""
_NO_WALL: Final = "no live pictures here: nothing is recorded, or a survey is shown"


class _Viewer:
    """One connection.

    Args:
        websocket: connection, accepted.
        watch: what this viewer watches.
        messages: messages to all viewers.
    """

    def __init__(self, websocket: WebSocket, watch: Watch, messages: WallMessages) -> None:
        self._websocket = websocket
        self._watch = watch
        self._messages = messages
        self._number = 0
        self._answered = asyncio.Event()
        self._refused = ""

    async def receive(self) -> NoReturn:
        """Take in choices and answers until the viewer leaves."""
        while True:
            message = await self._websocket.receive()
            if message["type"] == "websocket.disconnect":
                raise WebSocketDisconnect(message["code"])
            try:
                request = WALL_CLIENT_MESSAGE.validate_json(message.get("text") or message.get("bytes") or "")
            except ValidationError as error:
                self._refuse(problem_texts(error.errors(), "the message")[0])
                continue
            if isinstance(request, WallAnswer):
                if request.number == self._number:
                    self._answered.set()
            else:
                self._choose(request)

    def _choose(self, request: WallRequest) -> None:
        try:
            tiles = tuple(map(TileName.parse, request.tiles))
            self._watch.choose(tiles, is_large=request.large, rate_hz=request.rate_hz)
            self._refused = ""
        except (ValueError, InputDataError) as error:
            self._refuse(str(error))

    def _refuse(self, reason: str) -> None:
        self._refused = reason
        self._watch.nudge_now()

    async def send(self) -> NoReturn:
        """Send what is the newest, one message after the answer to the other, as long as the viewer may look."""
        while session_of(self._websocket).role.may(Role.OBSERVER):
            update = await self._watch.take()
            message = self._messages.message(update, refused=self._refused, after=self._number)
            self._number = message.number
            self._answered.clear()
            await self._send(message.data)
            async with asyncio.timeout(ANSWER_TIMEOUT_S):
                await self._answered.wait()
        await self._websocket.close(_POLICY)
        raise WebSocketDisconnect(_POLICY)

    async def _send(self, message: bytes) -> None:
        async with asyncio.timeout(SEND_TIMEOUT_S):
            try:
                await self._websocket.send_bytes(message)
            except RuntimeError as error:  # the server has closed the connection meanwhile, as it does when it ends
                raise WebSocketDisconnect(_GONE) from error


@router.websocket(WALL_PATH)
async def follow_wall(websocket: WebSocket) -> None:
    """Send newest pictures of the tiles that the viewer chooses, until it leaves or answers no more."""
    wall = wall_of(websocket)
    await websocket.accept()
    if wall is None:
        await websocket.close(_POLICY, _NO_WALL)
        return
    with wall.watch() as watch:
        viewer = _Viewer(websocket, watch, wall_messages_of(websocket))
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(viewer.send())
                await viewer.receive()
        except* (WebSocketDisconnect, TimeoutError):
            pass  # all of them end a connection normally
