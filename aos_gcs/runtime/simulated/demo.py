"""Simulated missions: simulator and service configured, started and scored together."""

from __future__ import annotations

import asyncio
import shutil
import socket
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aos_gcs.api.basemap_file import MISSION_BASEMAP
from aos_gcs.config.file import parse_config
from aos_gcs.errors import ConfigurationError, LinkError
from aos_gcs.lab.spacing import Spacing, spacing_for
from aos_gcs.lab.worlds import ErrorGrade
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.next_sortie import NextSortie
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.settings import Deadlines
from aos_gcs.runtime.service import Service, open_service
from aos_gcs.runtime.simulated.demo_terrain import EXIT_REFUSED, LEVEL, elevation_model, terrain_tables
from aos_gcs.runtime.simulated.evaluation import Score, score_mission
from aos_gcs.runtime.simulated.unused_ports import unused_ports

MAX_VEHICLES = 100
AUTOPILOTS = ("arducopter", "px4")
MAX_TREES_PER_HA = 2000
MIN_IMAGE_SIZE_PX, MAX_IMAGE_SIZE_PX = 16, 4096
MAX_BODIES = 100
"""Largest number of animals, and of stones. These limits are those of the simulator."""
ORIGIN_DEG = (48.3, 14.3, 260.0)
SEARCH_AREA_ENU_M = ((-25.0, 8.0), (25.0, 8.0), (25.0, 88.0), (-25.0, 88.0))
"""The part of the simulator's forest that hides the person; one leg of ten vehicles covers it."""
RELAY_AREA_ENU_M = ((-80.0, 8.0), (80.0, 8.0), (80.0, 168.0), (-80.0, 168.0))
"""Search area of a relay of batteries: the forest with the person, and meadow about it."""
RELAY_BATTERY_S = 540.0
RELAY_SPARES = 2
RELAY_SPEED_MPS = 1.5
"""Speed along the legs of a relay: the search takes longer than a battery lasts."""
MAX_SWAP_S = 3600.0
FOLDER_NAME = "simulation"
"""Folder within the mission folder for the simulator's truth and log."""

_STOP_TIMEOUT_S = 10.0


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """Options of a simulated mission.

    Raises:
        ConfigurationError: a value is out of its range.
    """

    vehicles: int = 10
    seed: int = 1
    strategy: str = "aos-apso"
    port: int | None = 8080
    """Port of the dashboard; None: no dashboard."""
    operator_code_file: Path | None = None
    """File with the code of operators; None: a random code."""
    speed: float = 1.0
    """Simulated seconds per second."""
    autopilot: str = "arducopter"
    trees_per_ha: float = 300.0
    image_size_px: int = 512
    errors: str = "rtk"
    """Grade of the simulator's errors."""
    animals: int = 2
    stones: int = 2
    terrain: str = LEVEL
    """Shape of the ground: ``flat``, ``hills``, ``slope:PERCENT`` or a file with heights."""
    follow_ground: bool = False
    """Whether the altitude layers follow the ground."""
    search_mode: str = ""
    """Flight along the legs: ``continuous`` or with ``stops``; empty: as missions do by default."""
    batteries: bool = False
    """Search for longer than a battery lasts, with vehicles that relieve others."""
    swap_s: float = 20.0
    """Time on the ground for another battery."""
    origin_deg: tuple[float, float, float] = ORIGIN_DEG
    """Launch site: latitude, longitude, and altitude above sea level in metres."""
    folder: Path = Path("missions")
    wait: bool = False
    """Leave start and return to the operator."""

    def __post_init__(self) -> None:
        if not 1 <= self.vehicles <= MAX_VEHICLES:
            raise ConfigurationError(f"--vehicles must lie within 1 and {MAX_VEHICLES}, but is {self.vehicles}.")
        if not 0.0 < self.speed <= 100.0:
            raise ConfigurationError(f"--speed must be above 0 and at most 100, but is {self.speed:g}.")
        if self.follow_ground and self.terrain == LEVEL:
            raise ConfigurationError("--follow-ground needs a --terrain to follow.")
        # The simulator checks them as well, but when the dashboard is up already.
        for name, choice, choices in (
            ("--autopilot", self.autopilot, AUTOPILOTS),
            ("--errors", self.errors, ErrorGrade),
            ("--search", self.search_mode, ("", *SearchMode)),
        ):
            if choice not in tuple(choices):
                raise ConfigurationError(
                    f"{name} must be one of {', '.join(filter(None, choices))}, but is {choice!r}."
                )
        ranges = (
            ("--trees-per-ha", self.trees_per_ha, 0, MAX_TREES_PER_HA),
            ("--image-size", self.image_size_px, MIN_IMAGE_SIZE_PX, MAX_IMAGE_SIZE_PX),
            ("--animals", self.animals, 0, MAX_BODIES),
            ("--stones", self.stones, 0, MAX_BODIES),
            ("--swap", self.swap_s, 1, MAX_SWAP_S),
            ("--vehicles", self.flown, 1, MAX_VEHICLES),
        )
        for name, value, least, most in ranges:
            if not least <= value <= most:
                raise ConfigurationError(f"{name} must lie within {least} and {most}, but is {value:g}.")

    @property
    def flown(self) -> int:
        """Number of simulated vehicles, with those that relieve others."""
        return self.vehicles + RELAY_SPARES * self.batteries


@dataclass(frozen=True, slots=True)
class Demo:
    """A simulated mission, ready to be run."""

    _options: DemoOptions
    _service: Service
    _link_port: int

    @property
    def mission(self) -> Coordinator:
        """The mission."""
        return self._service.mission

    @property
    def folder(self) -> Path:
        """Folder in which the mission is recorded."""
        return self._service.folder

    async def run(self) -> Score:
        """Run simulator and mission to the end, and return the score.

        Raises:
            ConfigurationError: the simulator has refused an option.
            LinkError: the simulator could not start, or not in time.
        """
        folder = self.folder / FOLDER_NAME
        await asyncio.to_thread(folder.mkdir)
        world_file, report_file = folder / "world.json", folder / "report.json"
        command = _simulator_command(self._options, self._link_port, world_file, report_file)
        if self._options.port is not None:
            command += ["--map-file", str(self.folder / MISSION_BASEMAP)]
        command += ["--clock-start", str(self._service.clock.start_utc_s)]
        async with _process(command, folder / "simulator.log") as simulator, asyncio.TaskGroup() as group:
            guard = group.create_task(self._watch(simulator, folder / "simulator.log"))
            snapshot = await self._service.run()
            guard.cancel()
        if not await asyncio.to_thread(world_file.exists):
            raise LinkError(f"The simulator was not ready in time; see {folder / 'simulator.log'}.")
        return await asyncio.to_thread(score_mission, snapshot, self.folder, world_file, report_file)

    async def stay(self) -> NextSortie | None:
        """Keep the dashboard up until an operator asks for a new sortie, and return what that begins with."""
        return await self._service.stay()

    async def _watch(self, simulator: asyncio.subprocess.Process, log: Path) -> None:
        """End the mission when the simulator ends before it does: its vehicles will not be heard again."""
        code = await simulator.wait()
        if self.mission.phase is not Phase.CONNECT:
            self.mission.end_without_vehicles()
        else:
            lines = (await asyncio.to_thread(log.read_text, encoding="utf-8", errors="replace")).strip().splitlines()
            reason = lines[-1] if lines else "it said nothing"
            if code == EXIT_REFUSED:
                raise ConfigurationError(reason.removeprefix("aos-gcs: "))
            raise LinkError(f"The simulator ended with code {code} before the mission began: {reason}")


@asynccontextmanager
async def open_demo(options: DemoOptions, following: NextSortie | None = None) -> AsyncIterator[Demo]:
    """Open the service for a simulated mission; its dashboard stays up for as long as the context is entered.

    A mission that has not heard of any vehicle leaves no folder behind. Each sortie has a simulator of its own: the
    same forest, with vehicles at their launch points and full batteries.

    Args:
        options: options of the mission.
        following: what the former sortie has left; None for the first one.

    Raises:
        ConfigurationError: an option cannot be used.
        LinkError: the dashboard's port is in use.
    """
    link_port = next(unused_ports(socket.SOCK_DGRAM))
    demo = None
    try:
        config = parse_config(_tables(options, link_port), source="demo")
        place = ",".join(map(str, options.origin_deg))
        ground = await elevation_model(options.terrain, seed=options.seed, origin=place, folder=options.folder)
        if ground is not None:
            tables = await asyncio.to_thread(terrain_tables, ground, config, follow=options.follow_ground)
            config = parse_config(_tables(options, link_port) | tables, source="demo")
        async with open_service(config, following) as service:
            demo = Demo(options, service, link_port)
            yield demo
    finally:
        if demo is not None and demo.mission.phase is Phase.CONNECT:
            await asyncio.to_thread(shutil.rmtree, demo.folder)


def _tables(options: DemoOptions, link_port: int) -> dict[str, Any]:
    """Return the tables of the service's configuration, over level ground."""
    spacing = spacing_for(options.errors)
    overrides = [f"{check}: {reason}" for check, reason in spacing.overrides.items()]
    return {
        "clock_speed": options.speed,
        "link": {"urls": [f"udpin://127.0.0.1:{link_port}"]},
        "mission": {
            "vehicles": options.vehicles,
            "any_vehicles": True,
            "origin_deg": options.origin_deg,
            "area_enu_m": RELAY_AREA_ENU_M if options.batteries else SEARCH_AREA_ENU_M,
            "seed": options.seed,
            "auto_start": not options.wait,
            "auto_return": not options.wait,
        },
        "swarm": {"strategy": options.strategy},
        "detection": {"stop_at_first": not options.batteries},
        "flight": {"layer_spacing_m": spacing.layers_m}
        | ({"search_speed_mps": RELAY_SPEED_MPS} if options.batteries else {}),
        "relay": {"enabled": options.batteries, "swap_s": options.swap_s},
        "search": {"mode": options.search_mode} if options.search_mode else {},
        "preflight": {"upload_fence": True, "set_return_height": True, "overrides": overrides},
        **_uncertainty_tables(spacing),
        "deadlines": _real_deadlines(max(1.0, options.speed)) | ({"search_s": 7200.0} if options.batteries else {}),
        "safety": {
            "max_link_age_s": 3.0 * max(1.0, options.speed),
            "max_position_age_s": 3.0 * max(1.0, options.speed),
        },
        "api": {
            "enabled": options.port is not None,
            "port": options.port or 0,
            "operator_code_file": options.operator_code_file,
        },
        "record": {"folder": options.folder},
    }


def _uncertainty_tables(spacing: Spacing) -> dict[str, Any]:
    if spacing.accuracy_m is None:
        return {}
    horizontal_m, vertical_m = spacing.accuracy_m
    uncertainty = {"position_horizontal_m": horizontal_m, "position_vertical_m": vertical_m}
    return {"uncertainty": uncertainty, "registration": {"enabled": True}}


def _real_deadlines(speed: float) -> dict[str, float]:
    """Return the deadlines for what takes real time, however fast the simulation: start-up, rendering, scheduling.

    The preflight is among it: parameters and geofences are transferred in as many messages as ever.
    """
    default = Deadlines()
    real = ("connect_s", "preflight_s", "capture_s", "search_s", "command_s", "lost_s", "all_lost_s")
    return {name: speed * getattr(default, name) for name in real}


def _simulator_command(options: DemoOptions, link_port: int, world_file: Path, report_file: Path) -> list[str]:
    return [
        *(sys.executable, "-m", "aos_gcs", "sim"),
        *("--vehicles", str(options.flown)),
        *("--link", f"udpout://127.0.0.1:{link_port}"),
        *("--seed", str(options.seed)),
        *("--speed", str(options.speed)),
        *("--autopilot", options.autopilot),
        *("--origin", ",".join(map(str, options.origin_deg))),
        *("--terrain", options.terrain),
        *("--trees-per-ha", str(options.trees_per_ha)),
        *("--image-size", str(options.image_size_px)),
        *("--errors", options.errors),
        *("--launch-spacing", str(spacing_for(options.errors).launch_m)),
        *(("--battery-life", str(RELAY_BATTERY_S), "--swap", str(options.swap_s)) if options.batteries else ()),
        *("--animals", str(options.animals)),
        *("--stones", str(options.stones)),
        *("--world-file", str(world_file)),
        *("--report-file", str(report_file)),
        "--exit-with-parent",
    ]


@asynccontextmanager
async def _process(command: list[str], log: Path) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run a program for as long as the context is entered; its output goes into a file."""
    with log.open("wb") as output:
        process = await asyncio.create_subprocess_exec(
            *command, stdin=asyncio.subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True
        )
        try:
            yield process
        finally:
            if process.returncode is None:
                process.terminate()
            try:
                async with asyncio.timeout(_STOP_TIMEOUT_S):
                    await process.wait()
            except TimeoutError:
                process.kill()
                await process.wait()
