"""The command ``aos-gcs demo``: a simulated swarm with the service and its dashboard."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.cli.run import CODE_FILE_HELP, run_until_terminated, stay_up
from aos_gcs.errors import ConfigurationError
from aos_gcs.input_values import finite_numbers

if TYPE_CHECKING:
    from aos_gcs.runtime.simulated.demo import DemoOptions
    from aos_gcs.runtime.simulated.evaluation import Score

EXIT_NOT_FOUND = 1


def demo(
    *,
    vehicles: Annotated[int, typer.Option(help="Number of vehicles, 1 to 100.")] = 10,
    seed: Annotated[int, typer.Option(help="Random seed for the world and the strategy.", min=0)] = 1,
    strategy: Annotated[str, typer.Option(help="Swarm strategy.")] = "aos-apso",
    headless: Annotated[bool, typer.Option("--headless", help="Run without the dashboard.")] = False,
    exit_when_done: Annotated[
        bool,
        typer.Option("--exit-when-done", help="Exit when the mission ends instead of keeping the dashboard available."),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
    port: Annotated[int, typer.Option(help="Port of the dashboard.", min=0, max=65535)] = 8080,
    operator_code_file: Annotated[Path | None, typer.Option(help=CODE_FILE_HELP, dir_okay=False)] = None,
    speed: Annotated[float, typer.Option(help="Simulation speed: simulated seconds per real second.")] = 1.0,
    autopilot: Annotated[str, typer.Option(help="Simulated autopilot: arducopter or px4.")] = "arducopter",
    trees_per_ha: Annotated[float, typer.Option(help="Trees per hectare of the simulated forest.")] = 300.0,
    image_size: Annotated[int, typer.Option(help="Width and height of the images in pixels.")] = 512,
    errors: Annotated[
        str, typer.Option(help="Errors of simulated vehicles, cameras and wind: none, rtk or gnss.")
    ] = "rtk",
    animals: Annotated[int, typer.Option(help="Deer and boars in the forest, which distract the search.")] = 2,
    stones: Annotated[int, typer.Option(help="Sun-warmed stones in the forest.")] = 2,
    terrain: Annotated[
        str,
        typer.Option(
            help="Shape of the ground, also known to the service as its elevation model: flat, hills, slope:PERCENT "
            "(rising to the north) or a GeoTIFF or ASC file with heights, which needs its --origin."
        ),
    ] = "flat",
    follow_ground: Annotated[
        bool, typer.Option("--follow-ground", help="Let the altitude layers follow the ground of --terrain.")
    ] = False,
    search: Annotated[
        str,
        typer.Option(
            metavar="MODE",
            help="Flight along the legs: continuous, or with stops for each frame.",
            show_default="as missions do by default",
        ),
    ] = "",
    batteries: Annotated[
        bool,
        typer.Option(
            "--batteries",
            help="Search a larger area with small batteries and two more vehicles: those that run low are relieved, "
            "get another battery on the ground, and relieve others.",
        ),
    ] = False,
    swap: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            help="Time on the ground for another battery with --batteries, in seconds.",
            show_default="20.0",
        ),
    ] = None,
    origin: Annotated[
        str, typer.Option(help="Launch site: LAT,LON,ALT in degrees and metres above sea level.")
    ] = "48.3,14.3,260",
    folder: Annotated[Path, typer.Option(help="Folder for recorded missions.")] = Path("missions"),
    wait: Annotated[bool, typer.Option("--wait", help="Leave launch and return to the operator.")] = False,
) -> None:
    """Find a person under trees with a simulated swarm, and watch it on the dashboard.

    Exit code 0 only if the person was found, announced within 3 m of where it is, and all vehicles have landed; 1 if
    not; 2 if nothing could be started.
    """
    from aos_gcs.runtime.simulated.demo import DemoOptions  # noqa: PLC0415 - heavy, only for this command

    if swap is not None and not batteries:
        raise ConfigurationError("--swap is the time for another battery: it needs --batteries.")
    if headless and wait:
        raise ConfigurationError("--wait leaves the launch to the dashboard, which --headless does without: give one.")
    if headless and operator_code_file is not None:
        raise ConfigurationError("--headless runs without the dashboard: leave --operator-code-file out.")
    options = DemoOptions(
        vehicles=vehicles,
        seed=seed,
        strategy=strategy,
        port=None if headless else port,
        operator_code_file=operator_code_file,
        speed=speed,
        autopilot=autopilot,
        trees_per_ha=trees_per_ha,
        image_size_px=image_size,
        errors=errors,
        animals=animals,
        stones=stones,
        terrain=terrain,
        follow_ground=follow_ground,
        search_mode=search,
        batteries=batteries,
        origin_deg=_place(origin),
        folder=folder,
        wait=wait,
    )
    if swap is not None:
        options = dataclasses.replace(options, swap_s=swap)
    score = run_until_terminated(_fly(options, as_json, stay=not (headless or exit_when_done)))
    if not (score.person_found and score.landed == score.vehicles):
        raise typer.Exit(EXIT_NOT_FOUND)


def _place(text: str) -> tuple[float, float, float]:
    match finite_numbers(text):
        case [latitude_deg, longitude_deg, altitude_amsl_m]:
            return latitude_deg, longitude_deg, altitude_amsl_m
    raise ConfigurationError(f"--origin must be LAT,LON,ALT (three numbers), got {text!r}.")


async def _fly(options: DemoOptions, as_json: bool, stay: bool) -> Score:
    from aos_gcs.cli.display.live import followed  # noqa: PLC0415 - heavy, only for this command
    from aos_gcs.runtime.simulated.demo import open_demo  # noqa: PLC0415

    following = None
    while True:
        async with open_demo(options, following) as flight:
            async with followed(flight.mission.view):
                score = await flight.run()
            _print(score, as_json)
            following = await stay_up(flight) if stay else None
        if following is None:
            return score


def _print(score: Score, as_json: bool) -> None:
    typer.echo(json.dumps(dataclasses.asdict(score)) if as_json else "\n".join(score.lines()))
