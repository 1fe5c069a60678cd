"""What would be sent of one state of a mission, without secrets and without a network."""

from __future__ import annotations

from collections.abc import Iterator
from urllib.parse import unquote

from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.caltopo.objects import VehicleTracks, objects
from aos_gcs.sharing.caltopo.requests import Credential, device_name, position_report, signed
from aos_gcs.sharing.heights import undulations
from aos_gcs.sharing.http import Request
from aos_gcs.sharing.settings import CaltopoSettings, SharingSettings, TakSettings, WebhookSettings
from aos_gcs.sharing.state import SeenState
from aos_gcs.sharing.tak.board import MarkBoard
from aos_gcs.sharing.tak.scene import scene
from aos_gcs.sharing.webhook.messages import FindingChanges, finding_message, started_message

_SECRET = "SECRET"  # noqa: S105 - stands for one


def preview(settings: SharingSettings, snapshot: MissionSnapshot, utc_s: float) -> Iterator[str]:
    """Yield what a receiver would be sent that sees this state first, one message after the other.

    Args:
        settings: receivers.
        snapshot: state of a mission.
        utc_s: present time, which messages carry.
    """
    if settings.tak is not None:
        yield from _tak(settings.tak, snapshot, utc_s)
    if settings.caltopo is not None:
        yield from _caltopo(settings.caltopo, snapshot, utc_s)
    if settings.webhook is not None:
        yield from _webhook(settings.webhook, snapshot, utc_s)


def _tak(settings: TakSettings, snapshot: MissionSnapshot, utc_s: float) -> Iterator[str]:
    shown = scene(SeenState(snapshot, 0.0), settings.name, undulations(settings.geoid), 0.0)
    for event in MarkBoard().due(shown, 0.0, utc_s):
        yield f"{settings.url} {event.decode()}"


def _caltopo(settings: CaltopoSettings, snapshot: MissionSnapshot, utc_s: float) -> Iterator[str]:
    url, tracks = settings.url.rstrip("/"), VehicleTracks()
    if snapshot.origin is None:
        return
    if settings.positions:
        frame = LocalFrame(snapshot.origin)
        for vehicle in SeenState(snapshot, 0.0).fresh_vehicles(0.0):
            if vehicle.position_enu_m is not None:
                device = device_name(settings.name, vehicle.telemetry.vehicle_id)
                yield _text(position_report(url, _SECRET, device, frame.to_geodetic(vehicle.position_enu_m)))
    if settings.map is not None and settings.credential_id is not None:
        nobody = Credential(settings.credential_id, b"")
        for one in objects(snapshot, tracks, settings.name).values():
            path = f"/api/v1/map/{settings.map}/{one.kind}"
            yield _text(signed(url, nobody, "POST", path, utc_s=utc_s, payload=one.payload))


def _webhook(settings: WebhookSettings, snapshot: MissionSnapshot, utc_s: float) -> Iterator[str]:
    changes = FindingChanges().since(snapshot)
    messages = [finding_message(event, finding, snapshot, utc_s) for event, finding in changes]
    for message in (started_message(snapshot.mission_id, utc_s), *messages):
        yield f"POST {settings.url} {message.body.decode()}"


def _text(request: Request) -> str:
    """Return a request as one line; signatures are those of no secret."""
    body = "" if request.body is None else " " + unquote(request.body.decode().replace("+", " "))
    return f"{request.method} {request.url}{body}"
