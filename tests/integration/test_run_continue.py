"""``aos-gcs run --continue`` as a process of its own: a later flight goes on with the map and the segments."""

from __future__ import annotations

import asyncio
import json
import sys
from pathlib import Path
from typing import Any

import pytest

from aos_gcs.geometry.geodesy import LocalFrame
from tests.fakes.ground_frames import ORIGIN
from tests.fakes.program import running, unused_port

CONFIGURATION = """
clock_speed = {speed}
[link]
urls = ["udpin://127.0.0.1:{port}"]
[mission]
vehicle_ids = [1]
vehicles = 1
area_enu_m = [[{west}, 20], [{east}, 20], [{east}, 40], [{west}, 40]]
auto_start = true
auto_return = true
{origin}
[forest]
canopy_height_m = 18.0
crown_base_m = 5.0
[search]
segments = "{segments}"
[preflight]
upload_fence = true
set_return_height = true
[deadlines]
connect_s = {connect_s}
capture_s = {capture_s}
[safety]
max_link_age_s = {age_s}
max_position_age_s = {age_s}
[api]
enabled = false
[record]
folder = "{folder}"
"""
SPEED = 10.0
LAUNCH = f"{ORIGIN.latitude_deg},{ORIGIN.longitude_deg},{ORIGIN.altitude_amsl_m}"
ORIGIN_LINE = f"origin_deg = [{LAUNCH}]"


def write_segments(file: Path) -> None:
    """Write the segments *west*, of the first flight's area, and *east*, of the second one's."""
    features = []
    for name, west_m, east_m in (("west", -60.0, -40.0), ("east", 40.0, 60.0)):
        corners = ((west_m, 20.0), (east_m, 20.0), (east_m, 40.0), (west_m, 40.0), (west_m, 20.0))
        places = [LocalFrame(ORIGIN).to_geodetic((*corner, 0.0)) for corner in corners]
        ring = [[place.longitude_deg, place.latitude_deg] for place in places]
        geometry = {"type": "Polygon", "coordinates": [ring]}
        features.append({"type": "Feature", "properties": {"name": name}, "geometry": geometry})
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}), "utf-8")


def write_file(folder: Path, port: int, west_m: float, east_m: float, origin: str) -> str:
    folder.mkdir()
    file = folder / "mission.toml"
    text = CONFIGURATION.format(
        port=port,
        speed=SPEED,
        west=west_m,
        east=east_m,
        origin=origin,
        segments=(folder.parent / "segments.geojson").as_posix(),
        connect_s=60.0 * SPEED,
        capture_s=20.0 * SPEED,
        age_s=3.0 * SPEED,
        folder=(folder / "missions").as_posix(),
    )
    file.write_text(text, "utf-8")
    return str(file)


async def fly(folder: Path, west_m: float, east_m: float, origin: str, *options: str) -> Path:
    """Search a strip with one simulated vehicle, and return the mission's folder."""
    port = unused_port()
    file = write_file(folder, port, west_m, east_m, origin)
    simulated = ("--vehicles", "1", "--link", f"udpout://127.0.0.1:{port}", "--speed", str(SPEED), "--origin", LAUNCH)
    world = ("--trees-per-ha", "0", "--persons", "0", "--image-size", "96", "--errors", "none")
    async with (
        running(folder / "sim", "sim", *simulated, *world),
        running(folder, "run", file, *options) as program,
    ):
        assert await program.ended(110) == 0, program.log
    return program.mission_folder


async def searched(folder: Path) -> dict[str, Any]:
    """Return what ``aos-gcs searched`` says of a mission."""
    arguments = (sys.executable, "-m", "aos_gcs", "searched", str(folder), "--json")
    process = await asyncio.create_subprocess_exec(*arguments, stdout=asyncio.subprocess.PIPE)
    output, _ = await process.communicate()
    figures: dict[str, Any] = json.loads(output)
    return figures


@pytest.mark.slow
async def test_a_second_flight_adds_to_the_segments_that_the_first_has_seen(tmp_path: Path) -> None:
    write_segments(tmp_path / "segments.geojson")
    # The areas meet, as they have to, between the segments.
    first = await fly(tmp_path / "monday", -60.0, 0.0, ORIGIN_LINE)
    second = await fly(tmp_path / "tuesday", -10.0, 60.0, "", "--continue", str(first))
    before, after = await searched(first), await searched(second)
    assert after["frames"] > before["frames"] > 0
    seen, seen_after = ({one["name"]: one for one in told["segments"]} for told in (before, after))
    assert seen["west"]["seen_fraction"] == seen_after["west"]["seen_fraction"] == 1.0
    assert seen_after["west"]["detection"] >= seen["west"]["detection"] > 0.0, "what Monday has seen is not lost"
    assert seen["east"]["seen_fraction"] < 0.1
    assert seen_after["east"]["seen_fraction"] == 1.0
