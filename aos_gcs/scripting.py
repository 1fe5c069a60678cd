"""Flying a swarm from a short script: connect, take off, fly to places, take frames, come home.

For flights without a search: to try a vehicle, a link or an autopilot in software, or to collect frames. Every waypoint
is vetted as in a mission (:func:`aos_gcs.airspace.vetting.vet_waypoints`), every vehicle has an altitude layer of its
own, the same monitor watches links, batteries and distances, and however the script ends, all vehicles are led home and
land. There is no operator and no dashboard: somebody has to watch.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import UNLIMITED, SafetyOverrides
from aos_gcs.clock import LoopClock
from aos_gcs.errors import ConfigurationError, MissionError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.bounds import FlightBounds
from aos_gcs.mission.fleet.datum import survey_ground
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.homes import home_elsewhere, next_home, take_off_point_enu_m
from aos_gcs.mission.fleet.landing.return_and_land import ReturnAndLand
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.monitor import Monitor
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.standing_hold import StandingHold
from aos_gcs.mission.fleet.vehicle_tasks import VehicleTasks
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.preflight.altitudes import check_altitudes
from aos_gcs.mission.preflight.telemetry import check_all
from aos_gcs.mission.preflight.terrain import check_take_off_altitudes, survey_terrain
from aos_gcs.mission.search.frames.sampling import Sample, sample
from aos_gcs.planning.descents import passes, staggered
from aos_gcs.planning.proposal import altitude_layers, propose_limits
from aos_gcs.planning.settings import Deadlines, FlightSettings, MissionSettings, TerrainSettings
from aos_gcs.ports import Arm, Clock, Disarm, DriverContext, Fleet, Severity, Takeoff, VehicleState
from aos_gcs.runtime.drivers import load_driver

_POLL_S = 0.2
_OURS = frozenset({Task.SWARM})

GroundPoint = tuple[float, float]
"""East and north of the first vehicle's launch point, in metres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptOptions:
    """Options of a script."""

    vehicles: int
    """Number of vehicles to wait for."""
    vehicle_ids: Sequence[int] = ()
    """System ids of the vehicles that fly; may be left out where no other vehicle is heard. Others are never armed."""
    area_enu_m: Sequence[GroundPoint]
    """Area in which vehicles fly: a simple polygon, relative to the launch point of the vehicle with the lowest id."""
    return_enu_m: GroundPoint | None = None
    """Point around which all vehicles land; None: each where it started."""
    driver: str = "mavlink"
    driver_options: Mapping[str, object] = field(default_factory=dict)
    flight: FlightSettings = field(default_factory=FlightSettings)
    deadlines: Deadlines = field(default_factory=Deadlines)
    safety: SafetyOverrides = field(default_factory=SafetyOverrides)
    """Safety limits that differ from those proposed around the area, the launch points and the layers."""
    terrain: TerrainSettings | None = None
    """Elevation model that the ways are checked against; None: the ground counts as level. Its
    ``floor_above_ground_m`` is 5 m below the lowest layer unless it is set: set it to what clears the trees."""
    clock_speed: float = 1.0
    """Clock seconds per real second; above 1 only with vehicles simulated at the same speed."""
    log_folder: Path | None = None
    """Folder in which the driver records its raw traffic; None: nowhere."""

    def __post_init__(self) -> None:
        if self.terrain is not None and self.terrain.follow:
            raise ConfigurationError(
                "terrain.follow is for missions only: scripts set no return heights, which layers over relief need. "
                "Leave it out."
            )


class Swarm:
    """Vehicles under a script's command. Made by :func:`open_swarm`."""

    def __init__(self, fleet: Fleet, clock: Clock, journal: Journal, options: ScriptOptions) -> None:
        self._options = options
        self._clock = clock
        self._roster = Roster(fleet, clock)
        self._bounds = FlightBounds(options.flight.arrival_radius_m)
        self._flight = FlightControl(
            self._roster, clock, journal, options.flight, options.deadlines, bounds=self._bounds
        )
        self._settings = MissionSettings(
            vehicles=options.vehicles,
            area_enu_m=tuple(options.area_enu_m),
            imaging=ImagingSettings(),
            safety=options.safety,
            return_enu_m=options.return_enu_m,
            flight=options.flight,
            deadlines=options.deadlines,
            terrain=options.terrain,
        )
        context = FlightContext(
            settings=self._settings,
            clock=clock,
            roster=self._roster,
            journal=journal,
            bounds=self._bounds,
            flight=self._flight,
        )
        self._vehicle_tasks = VehicleTasks(lambda: context)
        self._return_and_land = ReturnAndLand(context, self._vehicle_tasks)
        self._monitor = Monitor(
            lambda: self._return_and_land,
            publish=lambda: None,
            on_all_lost=self._give_up,
            standing_hold=StandingHold(),
        )
        self._journal = journal

    async def watch(self) -> None:
        """Watch links, batteries, take-overs and distances, until cancelled."""
        async with asyncio.TaskGroup() as group:
            group.create_task(self._vehicle_tasks.run())
            group.create_task(self._monitor.run())

    @property
    def vehicle_ids(self) -> tuple[int, ...]:
        """All vehicles that fly, by ascending id."""
        return tuple(member.vehicle_id for member in self._roster.chosen())

    def state(self, vehicle_id: int) -> VehicleState:
        """Return the latest telemetry of a vehicle.

        Raises:
            MissionError: there is no such vehicle.
        """
        (member,) = self._roster.select([vehicle_id])
        return member.state

    def position_enu_m(self, vehicle_id: int) -> NDArray[np.float64] | None:
        """Return a vehicle's position, shape (3,), relative to the first one's launch point; None if it is unknown.

        Raises:
            MissionError: there is no such vehicle.
        """
        (member,) = self._roster.select([vehicle_id])
        return self._roster.position_enu_m(member)

    async def get_ready(self) -> None:
        """Wait until all vehicles pass the checks of preflight, and give each its altitude layer.

        With an elevation model everything between the area, the launch points and the return point has to be clear of
        the ground.

        Raises:
            MissionError: a check still fails at the deadline, or the ground is too close; the text names it.
        """
        deadline_s = self._clock.now_s() + self._options.deadlines.connect_s + self._options.deadlines.preflight_s
        while (refusal := self._refusal()) is not None:
            if self._clock.now_s() >= deadline_s:
                raise MissionError(refusal.text)
            await self._clock.sleep(_POLL_S)
        self._set_limits()
        await self._survey_terrain()

    async def take_off(self) -> None:
        """Arm all and climb straight up, each to its own layer.

        Raises:
            MissionError: a vehicle does not; the others hover.
        """
        members = self._roster.chosen(Task.IDLE)
        _raise_first(self._flight.vet_climbs(members))
        armed = await self._flight.command_each(members, lambda _: Arm())
        for member in self._roster.select(vehicle_id for vehicle_id, refusal in armed.items() if refusal is None):
            if (refusal := await home_elsewhere(self._clock, member)) is not None:
                await self._flight.command(member, Disarm())
                armed[member.vehicle_id] = refusal
                continue
            self._roster.assign(member, Task.SWARM)
        climbed = await self._flight.command_each(
            self._roster.members(Task.SWARM), self._takeoff, self._options.deadlines.takeoff_s
        )
        _raise_first({**climbed, **{key: refusal for key, refusal in armed.items() if refusal is not None}})

    async def fly_to(self, places_enu_m: Mapping[int, GroundPoint]) -> None:
        """Fly vehicles to places, by id, in their layers, all at the same time, until they hover there.

        Every waypoint is vetted: a segment that leaves the geofence or comes too near to another vehicle or to the
        ground of an elevation model is shortened, or the vehicle is held.

        Raises:
            MissionError: there is no such vehicle, or a vehicle did not get there in time; the text names the reason.
        """
        requests = {
            member.vehicle_id: np.array([*places_enu_m[member.vehicle_id], member.layer_height_m])
            for member in self._roster.select(places_enu_m)
        }
        await self._flight.transfer(requests, _OURS)
        for member in self._roster.select(requests):
            if not self._flight.is_at(member, requests[member.vehicle_id]):
                reason = member.refusal or f"it is {member.task}, mode {member.state.mode_name}"
                raise MissionError(f"vehicle {member.vehicle_id} did not reach its place: {reason}")

    async def capture(self) -> Sample:
        """Expose one frame on all airborne vehicles at the same time; ``missing`` names those that deliver none."""
        return await sample(self._roster.airborne(), self._clock.now_s() + self._options.deadlines.capture_s)

    async def come_home(self) -> None:
        """Lead all home in their layers, land them there, and wait until their motors stand still.

        As at the end of a mission: a vehicle taken over by a pilot or its own failsafe is not commanded.

        Raises:
            MissionError: a vehicle still flies at the deadline.
        """
        await self._return_and_land.return_home()
        await self._return_and_land.land()
        left = [member for member in self._roster.members() if member.takes_part and member.state.armed]
        if left:
            state = "it is lost" if left[0].task is Task.LOST else f"mode {left[0].state.mode_name}"
            raise MissionError(f"vehicle {left[0].vehicle_id} has not landed: {state}")

    def _give_up(self) -> None:
        self._journal.notice(Severity.CRITICAL, "All vehicles are lost. Their own failsafes fly them.")

    def _refusal(self) -> Refusal | None:
        """Return why the swarm cannot start yet; None if it can."""
        named, expected = set(self._options.vehicle_ids), self._options.vehicles
        members = [m for m in self._roster.members() if not named or m.vehicle_id in named]
        if len(members) < expected:
            return Refusal(
                f"Only {len(members)} of {expected} vehicles are heard; check their power and the link's address."
            )
        if len(members) > expected:
            return Refusal(f"{len(members)} vehicles are heard, {expected} are to fly: name these by vehicle_ids.")
        self._roster.choose(member.vehicle_id for member in members)
        if self._roster.frame is None:
            home = next_home(members[0].state)
            if home is None:
                return Refusal(f"vehicle {members[0].vehicle_id} has no home position yet; wait for its GPS.")
            self._roster.frame = LocalFrame(home)
        limits = self._settings.safety.applied_to(UNLIMITED)
        found = [
            *check_all(self._roster, members, limits.launch_distance_m),
            *check_altitudes(self._roster, members, limits.separation_m, self._options.flight.layer_spacing_m),
        ]
        failed = [check for check in found if check.blocks]
        return Refusal(failed[0].describe()) if failed else None

    def _set_limits(self) -> None:
        members, roster, flight = self._roster.chosen(), self._roster, self._options.flight
        layers_m = altitude_layers(len(members), flight.lowest_layer_m, flight.layer_spacing_m)
        roster.ground = survey_ground([member.state for member in members])
        roster.settle_altitudes()
        homes_enu_m = [home_m for member in members if (home_m := take_off_point_enu_m(roster, member)) is not None]
        self._bounds.set(propose_limits(self._settings, homes_enu_m))
        clearance_m = self._flight.clearance_m(members)
        is_past = passes(self._settings.area_enu_m, np.array(homes_enu_m)[:, :2], clearance_m)
        roster.assign_layers(roster.chosen(), homes_enu_m, staggered(is_past, layers_m))

    async def _survey_terrain(self) -> None:
        """Compare the flight with the ground of the elevation model, and limit the heights above it."""
        terrain, frame, limits = self._options.terrain, self._roster.frame, self._bounds.limits
        if terrain is None or frame is None or limits is None:
            return
        members = self._roster.chosen()
        homes_enu_m = {member.vehicle_id: member.home_enu_m for member in members if member.home_enu_m is not None}
        found = await asyncio.to_thread(
            survey_terrain, self._settings, terrain, frame.origin, limits, homes_enu_m, scans=False
        )
        failed = [
            check for check in (*found.checks, *check_take_off_altitudes(members, frame, found.ground)) if check.blocks
        ]
        if failed:
            raise MissionError(failed[0].describe())
        self._bounds.set(found.limits, found.ground)

    def _takeoff(self, member: Member) -> Takeoff:
        if (height_m := self._roster.layers.above_home_m(member)) is None:
            raise MissionError(f"vehicle {member.vehicle_id} has no altitude layer: await get_ready() first")
        return Takeoff(height_m)


@asynccontextmanager
async def open_swarm(links: Sequence[str], options: ScriptOptions) -> AsyncIterator[Swarm]:
    """Connect, wait until all vehicles are ready, and yield the swarm; however the body ends, all are led home.

    Raises:
        ConfigurationError: a link, the driver or an option cannot be used.
        LinkError: a link cannot be opened.
        MissionError: the vehicles are not ready in time, or did not come home.
    """
    clock = LoopClock(options.clock_speed)
    journal, pulse = Journal(clock), LoopMonitor()
    context = DriverContext(
        clock=clock,
        is_healthy=pulse.is_healthy,
        notify=journal.take,
        log_folder=options.log_folder,
        options=options.driver_options,
    )
    async with load_driver(options.driver)(links, context) as fleet:
        swarm = Swarm(fleet, clock, journal, options)
        helpers = [asyncio.create_task(pulse.run(journal.note_stall)), asyncio.create_task(swarm.watch())]
        try:
            await swarm.get_ready()
            try:
                yield swarm
            finally:
                await swarm.come_home()
        finally:
            for helper in helpers:
                helper.cancel()
            for result in await asyncio.gather(*helpers, return_exceptions=True):
                if isinstance(result, Exception):
                    raise result


def _raise_first(results: Mapping[int, Refusal | None]) -> None:
    for vehicle_id, refusal in results.items():
        if refusal is not None:
            raise MissionError(f"vehicle {vehicle_id}: {refusal.text}")
