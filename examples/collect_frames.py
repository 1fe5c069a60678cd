"""Collect frames with their poses along a line, without any search.

python examples/collect_frames.py udpin://127.0.0.1:14550 frames

One .npz file per frame: image (H, W, C), bands, utc_s, position (latitude, longitude, altitude above mean sea level),
R_cam2enu and K.
"""

import argparse
import asyncio
from pathlib import Path

import numpy as np

from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Capture
from aos_gcs.scripting import ScriptOptions, Swarm, open_swarm

SPACING_M = 5.0


def save(capture: Capture, folder: Path) -> Path:
    path = folder / f"vehicle{capture.vehicle_id:03d}_image{capture.image_index:05d}.npz"
    position = capture.position
    np.savez_compressed(
        path,
        image=capture.image,
        bands=capture.bands,
        utc_s=capture.utc_s,
        position=(position.latitude_deg, position.longitude_deg, position.altitude_amsl_m),
        R_cam2enu=capture.R_cam2enu,
        K=capture.camera.K,
    )
    return path


async def collect(swarm: Swarm, folder: Path, stations: int, step_m: float) -> int:
    """Return the number of frames."""
    frames = 0
    await swarm.take_off()
    for station in range(stations):
        north_m = station * step_m
        await swarm.fly_to(
            {vehicle_id: (SPACING_M * place, north_m) for place, vehicle_id in enumerate(swarm.vehicle_ids)}
        )
        sample = await swarm.capture()
        for capture in sample.captures:
            await asyncio.to_thread(save, capture, folder)
        for vehicle_id, reason in sample.missing.items():
            print(f"station {station}: vehicle {vehicle_id}: {reason}")
        frames += len(sample.captures)
        print(f"station {station}: {len(sample.captures)} frames")
    return frames


async def run(links: list[str], options: ScriptOptions, folder: Path, stations: int, step_m: float) -> None:
    async with open_swarm(links, options) as swarm:
        frames = await collect(swarm, folder, stations, step_m)
    print(f"{frames} frames in {folder}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("link")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--driver", default="mavlink")
    parser.add_argument("--vehicles", type=int, default=3)
    parser.add_argument("--stations", type=int, default=5)
    parser.add_argument("--step", type=float, default=5.0, help="metres between stations")
    parser.add_argument("--height", type=float, default=30.0, help="of the lowest vehicle, metres")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    width_m, length_m = SPACING_M * arguments.vehicles, arguments.step * arguments.stations
    options = ScriptOptions(
        vehicles=arguments.vehicles,
        area_enu_m=((0.0, 0.0), (width_m, 0.0), (width_m, length_m), (0.0, length_m)),
        driver=arguments.driver,
        flight=FlightSettings(lowest_layer_m=arguments.height, layer_spacing_m=3.5),
    )
    asyncio.run(run([arguments.link], options, arguments.folder, arguments.stations, arguments.step))


if __name__ == "__main__":
    main()
