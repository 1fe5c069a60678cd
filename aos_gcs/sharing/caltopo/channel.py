"""Sharing with CalTopo: positions every few seconds, never old ones, and a map that follows the mission."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any, NoReturn

from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.sharing.caltopo.board import Change, MapBoard
from aos_gcs.sharing.caltopo.objects import VehicleTracks, objects
from aos_gcs.sharing.caltopo.requests import Credential, device_name, position_report, signed
from aos_gcs.sharing.channel import PAUSES_S, ChannelError, SendsOnly, StatusBoard
from aos_gcs.sharing.http import Answer, Request, Requests
from aos_gcs.sharing.settings import CaltopoSettings, without_secrets
from aos_gcs.sharing.state import SeenState
from aos_gcs.sharing.wording import finding_uid, is_shown

REPORT_S = 3.0
"""Shortest time between two reports of a vehicle."""
_AT_ONCE = 8
"""Reports that may be under way together."""
_LOOK_S = 0.5
_CLOCK_S = 60.0
"""Difference of the clocks that explains a refusal: signatures expire after two minutes."""


class PositionChannel(SendsOnly):
    """Reports the positions of the vehicles.

    Args:
        settings: the service.
        connect_key: key of the access URL.
        client: makes the requests.
        now_s: real seconds of the clock that the processes share.
        utc_s: clock for people.
    """

    def __init__(
        self,
        settings: CaltopoSettings,
        connect_key: str,
        client: Requests,
        now_s: Callable[[], float],
        utc_s: Callable[[], float],
    ) -> None:
        self._settings = settings
        self._connect_key = connect_key
        self._client = client
        self._now_s = now_s
        self._state: SeenState | None = None
        self._reported_at_s: dict[int, float] = {}
        self._statuses = StatusBoard("CalTopo positions", without_secrets(settings.url), utc_s)

    @property
    def status(self) -> ChannelStatus:
        """State of the reports."""
        return self._statuses.status

    def put(self, state: SeenState) -> None:
        """Take a newer state; returns at once."""
        self._state = state

    def take(self, notice: NoticeRecord) -> None:
        """Ignore a notice."""

    async def run(self) -> NoReturn:
        """Report until cancelled."""
        failures = 0
        try:
            while True:
                try:
                    await self._report_due()
                    failures = 0
                    await asyncio.sleep(_LOOK_S)
                except ChannelError as error:
                    self._statuses.failed(error)
                    await asyncio.sleep(PAUSES_S[min(failures, len(PAUSES_S) - 1)])
                    failures += 1
        finally:
            await self._client.close()

    async def _report_due(self) -> None:
        """Report the vehicles that are due, the first failure of which raises."""
        due = [number for number in self._fresh() if self._now_s() - self._reported_at_s.get(number, -1e9) >= REPORT_S]
        turns = asyncio.Semaphore(_AT_ONCE)
        failures = await asyncio.gather(*(self._report(number, turns) for number in due))
        for failure in failures:
            if failure is not None:
                raise failure

    async def _report(self, number: int, turns: asyncio.Semaphore) -> ChannelError | None:
        async with turns:
            # Looked up when it is sent: the service takes a position for one of that time.
            request = self._fresh().get(number)
            if request is None:
                return None
            self._reported_at_s[number] = self._now_s()
            try:
                answer = await self._client.request(request)
            except ChannelError as error:
                return error
        if not answer.is_success:
            return answer.error("check the connect key")
        self._statuses.sent()
        self._statuses.connected("Positions are taken")
        return None

    def _fresh(self) -> dict[int, Request]:
        """Return the reports of the vehicles whose positions are recent, by their ids."""
        state = self._state
        if state is None or state.snapshot.origin is None:
            return {}
        frame, requests = LocalFrame(state.snapshot.origin), {}
        for vehicle in state.fresh_vehicles(self._now_s()):
            if vehicle.position_enu_m is None:
                continue
            number = vehicle.telemetry.vehicle_id
            device, url = device_name(self._settings.name, number), self._settings.url.rstrip("/")
            place = frame.to_geodetic(vehicle.position_enu_m)
            requests[number] = position_report(url, self._connect_key, device, place)
        return requests


class MapChannel(SendsOnly):
    """Keeps findings, area, legs and tracks on a map up to date, one request after the other.

    Args:
        settings: the service, with a map.
        credential: credential of the service account.
        client: makes the requests.
        now_s: steady clock in real seconds.
        utc_s: clock for people, by which requests expire.
    """

    def __init__(
        self,
        settings: CaltopoSettings,
        credential: Credential,
        client: Requests,
        now_s: Callable[[], float],
        utc_s: Callable[[], float],
    ) -> None:
        self._settings = settings
        self._credential = credential
        self._client = client
        self._now_s = now_s
        self._utc_s = utc_s
        self._state: SeenState | None = None
        self._tracks = VehicleTracks()
        self._board = MapBoard()
        self._statuses = StatusBoard("CalTopo map", without_secrets(settings.url), utc_s)

    @property
    def status(self) -> ChannelStatus:
        """State of the map."""
        return self._statuses.status

    def put(self, state: SeenState) -> None:
        """Take a newer state; returns at once."""
        self._state = state
        for vehicle in state.fresh_vehicles(self._now_s()):
            if vehicle.position_enu_m is not None and vehicle.takes_part:
                self._tracks.note(vehicle.telemetry.vehicle_id, *vehicle.position_enu_m[:2])

    def take(self, notice: NoticeRecord) -> None:
        """Ignore a notice."""

    async def run(self) -> NoReturn:
        """Keep the map up to date until cancelled."""
        failures = 0
        try:
            while True:
                try:
                    await self._read_map()
                    failures = 0
                    while True:
                        await self._make(self._due())
                except ChannelError as error:
                    self._statuses.failed(error)
                    await asyncio.sleep(PAUSES_S[min(failures, len(PAUSES_S) - 1)])
                    failures += 1
        finally:
            await self._client.close()

    async def _read_map(self) -> None:
        """Read what is on the map: a request that got no answer may have been carried out."""
        answer = await self._request("GET", f"/api/v1/map/{self._settings.map}/since/0")
        features = _result(answer).get("state", {})
        self._board.read(features.get("features", []) if isinstance(features, dict) else [])
        self._statuses.connected("The map is up to date")

    def _due(self) -> Change | None:
        if self._state is None:
            return None
        snapshot, name = self._state.snapshot, self._settings.name
        withdrawn = (
            f"{name}.{finding_uid(one, snapshot.mission_id)}" for one in snapshot.findings if not is_shown(one)
        )
        return self._board.next_change(objects(snapshot, self._tracks, name), withdrawn, self._now_s())

    async def _make(self, change: Change | None) -> None:
        if change is None:
            await asyncio.sleep(_LOOK_S)
            return
        path = f"/api/v1/map/{self._settings.map}/{change.kind}"
        if change.feature_id is not None:
            path += f"/{change.feature_id}"
        if change.payload is None:
            await self._request("DELETE", path)
            feature_id = None
        else:
            result = _result(await self._request("POST", path, change.payload))
            feature_id = result.get("id") if isinstance(result.get("id"), str) else change.feature_id
            if feature_id is None:
                raise ChannelError("The service has not named the object that it made.")
        self._board.made(change, feature_id, self._now_s())
        self._statuses.sent()

    async def _request(self, method: str, path: str, payload: Any = None) -> Answer:
        url, utc_s = self._settings.url.rstrip("/"), self._utc_s()
        request = signed(url, self._credential, method, path, utc_s=utc_s, payload=payload)
        answer = await self._client.request(request)
        if answer.is_success or (method == "DELETE" and answer.status == 404):
            return answer
        ahead_s = 0.0 if answer.date_utc_s is None else answer.date_utc_s - utc_s
        if abs(ahead_s) > _CLOCK_S:
            text = f"The service's clock differs from this machine's by {abs(ahead_s) / 60.0:.0f} min: set the clock."
            raise ChannelError(text, is_refused=True)
        raise answer.error("check the id of the map, the credential and its permission")


def _result(answer: Answer) -> dict[str, Any]:
    """Return what a request has led to; empty where the answer does not say."""
    try:
        document = json.loads(answer.body)
    except ValueError:
        return {}
    result = document.get("result") if isinstance(document, dict) else None
    return result if isinstance(result, dict) else {}
