"""The event stream, on which operators can also hold all vehicles."""

from __future__ import annotations

import asyncio
from typing import Annotated, Final, NoReturn

from fastapi import APIRouter, Query, Response, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from aos_gcs.api.access.control import Control
from aos_gcs.api.access.roles import Role, Session
from aos_gcs.api.convert.mission import action_results
from aos_gcs.api.dependencies import Hub, access_of, commands_of, once_of, session_of
from aos_gcs.api.errors import status_and_id
from aos_gcs.api.events.hub import EventHub
from aos_gcs.api.events.outbox import Outbox
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.messages import AnswerMessage, HoldMessage, MissedEventsModel
from aos_gcs.api.models.mission import ActionResponse
from aos_gcs.errors import AosError
from aos_gcs.mission.model.actions import Action

router = APIRouter()

HEARTBEAT_INTERVAL_S = 0.5
"""Longest silence: after less than two seconds without a message the page considers the connection lost."""
SEND_TIMEOUT_S = 10.0
"""Time after which a client that accepts no data is disconnected."""
HOLDS_AT_ONCE: Final = 8
"""Holds of one client in progress; more are not answered."""
_DONE: Final = 200
_SIGNED_OUT: Final = 1008
"""Code of connections whose session has ended, where those who have not signed in see nothing."""
_GONE: Final = 1006
"""Code of connections that have ended without a word."""


@router.get("/api/events", response_model=MissedEventsModel)
async def read_missed_events(after: Annotated[int, Query(ge=0)], hub: Hub) -> Response:
    """Return the events after a number, for a client that was away; if that is too long ago, the whole state."""
    return Response(hub.missed_text(after), media_type="application/json")


@router.websocket("/api/events")
async def follow_events(websocket: WebSocket, hub: Hub) -> None:
    """Send ``hello``, then events and changes, until the client leaves or the service ends; carry out its holds."""
    await websocket.accept()
    presence = _Presence(access_of(websocket).control)
    try:
        async with asyncio.TaskGroup() as group:
            group.create_task(_send_events(websocket, hub, presence))
            await _receive_holds(websocket, group)
    except* (WebSocketDisconnect, TimeoutError):
        pass  # both end a connection normally
    finally:
        presence.end()


class _Presence:
    """Operator who is present by a page: as long as it is open, and as long as its session may command."""

    def __init__(self, control: Control) -> None:
        self._control = control
        self._name = ""

    def look(self, session: Session) -> None:
        """Note whose page it is now: accounts are removed, and get other roles, while pages are open."""
        name = session.name if session.role.may(Role.OPERATOR) else ""
        if name == self._name:
            return
        former = self._name
        self.end()
        if former:
            self._control.leave(former)
        if name:
            self._control.begin_following(name)
        self._name = name

    def end(self) -> None:
        """Note that the page is gone."""
        if self._name:
            self._control.end_following(self._name)
        self._name = ""


async def _receive_holds(websocket: WebSocket, group: asyncio.TaskGroup) -> NoReturn:
    """Read what the client sends until it leaves; ignore all but holds."""
    holding: set[asyncio.Task[None]] = set()
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message["code"])
        try:
            request = HoldMessage.model_validate_json(message.get("text") or "")
        except ValidationError:
            continue
        if len(holding) < HOLDS_AT_ONCE:
            task = group.create_task(_hold(websocket, request.request_id))
            holding.add(task)
            task.add_done_callback(holding.discard)


async def _hold(websocket: WebSocket, request_id: str) -> None:
    """Hold all vehicles, and send the answer."""
    try:
        response, error, status = await _hold_all(websocket, request_id), None, _DONE
    except AosError as refusal:
        status, error_id = status_and_id(refusal)
        response, error = None, ErrorModel(id=error_id, message=str(refusal))
    answer = AnswerMessage(request_id=request_id, status=status, response=response, error=error)
    await _send(websocket, answer.model_dump_json())


async def _hold_all(websocket: WebSocket, request_id: str) -> ActionResponse:
    session, once = session_of(websocket), once_of(websocket)
    access_of(websocket).check(session, Role.OPERATOR)
    commands = commands_of(websocket)
    key = session.name, Action.HOLD, None, request_id
    results = await once.run(key, lambda: commands.act(Action.HOLD, None, None, operator=session.name, seen=None))
    return action_results(Action.HOLD, results)


async def _send_events(websocket: WebSocket, hub: EventHub, presence: _Presence) -> NoReturn:
    with hub.connect() as outbox:
        while (session := session_of(websocket)).role.may(Role.OBSERVER):
            presence.look(session)
            await _send(websocket, await _next_message(outbox))
    presence.look(session)
    await websocket.close(_SIGNED_OUT)
    raise WebSocketDisconnect(_SIGNED_OUT)


async def _next_message(outbox: Outbox) -> str:
    try:
        async with asyncio.timeout(HEARTBEAT_INTERVAL_S):
            return await outbox.take()
    except TimeoutError:
        return outbox.heartbeat()


async def _send(websocket: WebSocket, text: str) -> None:
    async with asyncio.timeout(SEND_TIMEOUT_S):
        try:
            await websocket.send_text(text)
        except RuntimeError as error:  # the server has closed the connection meanwhile, as it does when it ends
            raise WebSocketDisconnect(_GONE) from error
