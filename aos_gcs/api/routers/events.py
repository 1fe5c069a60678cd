"""The event stream."""

from __future__ import annotations

import asyncio
from typing import Annotated, NoReturn

from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect

from aos_gcs.api.dependencies import Hub
from aos_gcs.api.events.hub import EventHub
from aos_gcs.api.events.outbox import Outbox
from aos_gcs.api.models.messages import MissedEventsModel

router = APIRouter()

HEARTBEAT_INTERVAL_S = 0.5
"""Longest silence: after less than two seconds without a message the page considers the connection lost."""
SEND_TIMEOUT_S = 10.0
"""Time after which a client that accepts no data is disconnected."""


@router.get("/api/events")
async def read_missed_events(after: Annotated[int, Query(ge=0)], hub: Hub) -> MissedEventsModel:
    """Return the events after a number, for a client that was away; if that is too long ago, the whole state."""
    return hub.missed(after)


@router.websocket("/api/events")
async def follow_events(websocket: WebSocket, hub: Hub) -> None:
    """Send ``hello``, then events and changes, until the client leaves or the service ends."""
    await websocket.accept()
    try:
        async with asyncio.TaskGroup() as group:
            group.create_task(_send_events(websocket, hub))
            await _wait_for_disconnect(websocket)
    except* (WebSocketDisconnect, TimeoutError):
        pass  # both end a connection normally


async def _wait_for_disconnect(websocket: WebSocket) -> NoReturn:
    """Read and ignore what the client sends."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message["code"])


async def _send_events(websocket: WebSocket, hub: EventHub) -> NoReturn:
    with hub.connect() as outbox:
        while True:
            await _send(websocket, await _next_message(outbox))


async def _next_message(outbox: Outbox) -> str:
    try:
        async with asyncio.timeout(HEARTBEAT_INTERVAL_S):
            return await outbox.take()
    except TimeoutError:
        return outbox.heartbeat()


async def _send(websocket: WebSocket, text: str) -> None:
    async with asyncio.timeout(SEND_TIMEOUT_S):
        await websocket.send_text(text)
