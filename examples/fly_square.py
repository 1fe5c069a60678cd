"""Fly a square with a small swarm, side by side.

python examples/fly_square.py udpin://127.0.0.1:14550            (real vehicles, or your own SITL)
python examples/fly_square.py --driver mavsdk --side 40 udpin://127.0.0.1:14550
"""

import argparse
import asyncio

from aos_gcs.planning.settings import FlightSettings
from aos_gcs.scripting import ScriptOptions, Swarm, open_swarm

SPACING_M = 5.0


async def fly_square(swarm: Swarm, side_m: float) -> None:
    await swarm.take_off()
    for east_m, north_m in ((0.0, side_m), (side_m, side_m), (side_m, 0.0), (0.0, 0.0)):
        await swarm.fly_to(
            {vehicle_id: (east_m + SPACING_M * place, north_m) for place, vehicle_id in enumerate(swarm.vehicle_ids)}
        )
        print(f"corner {east_m:g} m east, {north_m:g} m north")


async def run(links: list[str], options: ScriptOptions, side_m: float) -> None:
    async with open_swarm(links, options) as swarm:
        await fly_square(swarm, side_m)
    print("all have landed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("links", nargs="+")
    parser.add_argument("--driver", default="mavlink")
    parser.add_argument("--vehicles", type=int, default=3)
    parser.add_argument("--side", type=float, default=20.0, help="metres")
    parser.add_argument("--height", type=float, default=20.0, help="of the lowest vehicle, metres")
    arguments = parser.parse_args()
    reach_m = arguments.side + SPACING_M * arguments.vehicles
    options = ScriptOptions(
        vehicles=arguments.vehicles,
        area_enu_m=((0.0, 0.0), (reach_m, 0.0), (reach_m, reach_m), (0.0, reach_m)),
        driver=arguments.driver,
        flight=FlightSettings(lowest_layer_m=arguments.height, layer_spacing_m=3.5),
    )
    asyncio.run(run(arguments.links, options, arguments.side))


if __name__ == "__main__":
    main()
