"""The mission as KML that programs ask for again and again, and findings with their pictures in one file."""

from __future__ import annotations

import asyncio
import io
import zipfile
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import httpx
import pytest

from aos_gcs.exports.live_kml import live_kml
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.runtime.recorded.viewer import Viewer
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock
from tests.fakes.scripted_vehicle import ORIGIN
from tests.fakes.sharing import parsed, scripted
from tests.fakes.viewed_step import record_viewed_step

NAMESPACE = {"k": "http://www.opengis.net/kml/2.2"}


def names(document: ET.Element) -> list[str]:
    return [name.text or "" for name in document.iterfind(".//k:Placemark/k:name", NAMESPACE)]


@pytest.fixture
def mission() -> ScriptedMission:
    return ScriptedMission(HandClock())


@pytest.fixture
async def client(mission: ScriptedMission, tmp_path: Path) -> AsyncIterator[httpx.AsyncClient]:
    folder = await record_viewed_step(tmp_path)
    viewer = Viewer(folder, ImagingSettings(), focus_reach_m=10.0)
    app = app_of(mission, viewer=viewer, operator_code="larch")
    transport = httpx.ASGITransport(app)
    async with httpx.AsyncClient(transport=transport, base_url="http://192.168.4.1:8080") as client:
        yield client


async def test_the_link_leads_back_to_the_station_by_the_address_that_was_used(client: httpx.AsyncClient) -> None:
    answer = await client.get("/api/network-link.kml")
    assert answer.headers["content-type"].startswith("application/vnd.google-earth.kml+xml")
    link = parsed(answer.content)
    assert link.findtext(".//k:href", namespaces=NAMESPACE) == "http://192.168.4.1:8080/api/live.kml"
    assert link.findtext(".//k:refreshMode", namespaces=NAMESPACE) == "onInterval"
    assert link.findtext(".//k:refreshInterval", namespaces=NAMESPACE) == "10"


async def test_observers_see_vehicles_area_and_findings_but_not_those_that_were_rejected(
    client: httpx.AsyncClient, mission: ScriptedMission
) -> None:
    await mission.add_finding((10.0, 20.0, 0.0), "<b>jacket</b>", operator="Ada")
    await mission.add_finding((15.0, 20.0, 0.0), "", operator="Ada")
    await mission.change_finding(2, FindingChange(FindingStatus.REJECTED), operator="Ada")
    document = parsed((await client.get("/api/live.kml")).content)
    shown = names(document)
    assert [one for one in shown if one.startswith("Finding")] == ["Finding 1"]
    assert {"Vehicle 1", "Search area"} <= set(shown)
    assert "Vehicle 7" not in shown


def test_vehicles_are_above_the_sea_and_legs_are_those_that_were_flown() -> None:
    legs = (((0.0, 0.0), (0.0, 50.0)), ((10.0, 0.0), (10.0, 50.0)))
    snapshot = scripted()
    vehicle = replace(snapshot.vehicles[0], position_enu_m=(0.0, 0.0, 35.0))
    text = live_kml(replace(snapshot, vehicles=(vehicle,), legs_enu_m=legs, leg=1), ORIGIN)
    document = parsed(text.encode())
    assert [name for name in names(document) if name.startswith("Leg")] == ["Leg 1, flown"]
    point = document.find(".//k:Point", NAMESPACE)
    assert point is not None
    assert point.findtext("k:altitudeMode", namespaces=NAMESPACE) == "absolute"
    longitude_deg, latitude_deg, altitude_m = map(float, point.findtext("k:coordinates", "", NAMESPACE).split(","))
    expected = (ORIGIN.longitude_deg, ORIGIN.latitude_deg, ORIGIN.altitude_amsl_m + 35.0)
    assert (longitude_deg, latitude_deg, altitude_m) == pytest.approx(expected, abs=0.01)


async def test_a_kmz_shows_the_pictures_of_the_findings_and_what_people_wrote_as_text(
    client: httpx.AsyncClient, mission: ScriptedMission
) -> None:
    mission.make_step()
    await mission.add_finding((0.0, 0.0, 0.0), "<script>x</script>", operator="Ada")
    answer = await client.get("/api/findings.kmz")
    assert answer.headers["content-type"] == "application/vnd.google-earth.kmz"
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.testzip() is None
        files = archive.namelist()
        document = parsed(archive.read("doc.kml"))
        pictures = [archive.read(name) for name in files if name.endswith(".png")]
    assert files[0] == "doc.kml"
    assert all(picture.startswith(b"\x89PNG") for picture in pictures)
    balloon = document.findtext(".//k:description", "", NAMESPACE)
    assert "&lt;script&gt;" in balloon
    assert "<script>" not in balloon
    assert pictures
    assert all(f'src="{name}"' in balloon for name in files[1:])


async def test_a_mission_without_frames_has_findings_without_pictures(mission: ScriptedMission) -> None:
    mission.make_step()
    await mission.add_finding((0.0, 0.0, 0.0), "", operator="Ada")
    transport = httpx.ASGITransport(app_of(mission))
    async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
        answer = await client.get("/api/findings.kmz")
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.namelist() == ["doc.kml"]
    await asyncio.sleep(0)
