"""The event stream."""

from __future__ import annotations

import asyncio
from typing import NoReturn

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from aos_gcs.api.dependencies import Hub
from aos_gcs.api.hub import EventHub
from aos_gcs.api.messages import HeartbeatMessage, ServerMessage
from aos_gcs.api.outbox import Outbox

router = APIRouter()

HEARTBEAT_INTERVAL_S = 0.5
"""Of silence; the page takes the connection for lost after less than two seconds without a message."""
SEND_TIMEOUT_S = 10.0
"""A client that takes nothing for so long is gone."""


@router.websocket("/api/events")
async def follow_events(websocket: WebSocket, hub: Hub) -> None:
    """Send ``hello`` and then every event, until the client leaves or the service ends."""
    await websocket.accept()
    try:
        async with asyncio.TaskGroup() as group:
            group.create_task(_send_events(websocket, hub))
            await _wait_for_disconnect(websocket)
    except* (WebSocketDisconnect, TimeoutError):
        pass  # the ends that a connection has


async def _wait_for_disconnect(websocket: WebSocket) -> NoReturn:
    """Read and ignore what the client sends."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message["code"])


async def _send_events(websocket: WebSocket, hub: EventHub) -> NoReturn:
    with hub.connect() as outbox:
        await _send(websocket, hub.hello())
        while True:
            await _send(websocket, await _next_message(outbox))


async def _next_message(outbox: Outbox) -> ServerMessage:
    try:
        async with asyncio.timeout(HEARTBEAT_INTERVAL_S):
            return await outbox.take()
    except TimeoutError:
        return HeartbeatMessage(seq=outbox.seq)


async def _send(websocket: WebSocket, message: ServerMessage) -> None:
    async with asyncio.timeout(SEND_TIMEOUT_S):
        await websocket.send_text(message.model_dump_json())
