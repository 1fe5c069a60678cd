"""Commands to the vehicles of a mission: all at once, none waiting for another, every waypoint vetted."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.accuracy import Accuracy, beside_errors_m
from aos_gcs.airspace.plans import TrafficSituation, vet_plan
from aos_gcs.airspace.reference_surface import LEVEL
from aos_gcs.airspace.traffic import ALL_ADMITTED, Admission, Obstacle, Traffic, WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.errors import CommandError, CommandRefusedError
from aos_gcs.mission.fleet.accuracies import accuracy_on_paths
from aos_gcs.mission.fleet.bounds import FlightBounds
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.motion import (
    destination_enu_m,
    hovers_at_waypoint,
    is_ours,
    must_stop,
    why_left,
)
from aos_gcs.mission.fleet.obstacles import obstacle_of, stop_enu_m
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.handler_watch import sign_of_life
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.ports import Clock, Command, Goto, Hold, Severity

_POLL_S = 0.1
_RETRY_S = 1.0
"""Time between two attempts to send a vehicle that has refused."""
_SWARM = frozenset({Task.SWARM})


class FlightControl:
    """The only place from which a mission commands its vehicles.

    Args:
        roster: vehicles of the mission.
        clock: clock of the station.
        journal: told of commands that fail.
        settings: speeds, layers and arrival.
        deadlines: time limits of commands and transfers.
        bounds: limits that waypoints are vetted against.
    """

    def __init__(
        self,
        roster: Roster,
        clock: Clock,
        journal: Journal,
        settings: FlightSettings,
        deadlines: Deadlines,
        *,
        bounds: FlightBounds,
    ) -> None:
        self._roster = roster
        self._clock = clock
        self._journal = journal
        self._settings = settings
        self._deadlines = deadlines
        self._bounds = bounds

    async def command(
        self, member: Member, command: Command, timeout_s: float | None = None, *, is_repeated: bool = False
    ) -> Refusal | None:
        """Have one vehicle do something; return None when it is confirmed, else the refusal, which is also reported.

        Refusals of a command that is repeated have been reported before.
        """
        now_s = self._clock.now_s()
        deadline_s = now_s + (timeout_s if timeout_s is not None else self._deadlines.command_s)
        member.last_command = command
        if not isinstance(command, Hold):
            member.sent_at_s = now_s
        try:
            await member.vehicle.execute(command, deadline_s)
        except CommandError as error:
            if isinstance(error, CommandRefusedError) and member.last_command is command:
                member.last_command = None
            if not is_repeated:
                self._journal.notice(Severity.WARNING, f"{_name(command)}: {error}", member.vehicle_id)
            return Refusal(str(error))
        return None

    async def command_each(
        self,
        members: Iterable[Member],
        command_for: Callable[[Member], Command],
        timeout_s: float | None = None,
        on_handed_over: Callable[[], None] | None = None,
    ) -> dict[int, Refusal | None]:
        """Command several vehicles at the same time and return what became of it by id: None where it is confirmed.

        ``on_handed_over`` is called when every command has been given to the link, before any is confirmed.
        """
        sign_of_life(self._deadlines.command_s if timeout_s is None else timeout_s)
        async with asyncio.TaskGroup() as group:
            tasks = {
                member.vehicle_id: group.create_task(self.command(member, command_for(member), timeout_s))
                for member in members
            }
            await asyncio.sleep(0)
            if on_handed_over is not None:
                on_handed_over()
        sign_of_life()
        return {vehicle_id: task.result() for vehicle_id, task in tasks.items()}

    def vet(
        self,
        requests: Mapping[int, NDArray[np.float64]],
        tasks: frozenset[Task] = _SWARM,
        *,
        returning: bool = False,
    ) -> tuple[WaypointRecord, ...]:
        """Check planned waypoints, shape (3,) each, against the limits, each other and all other airborne vehicles.

        Where a boundary blocks the straight path and there is a path around it, the next corner of that is granted.

        Args:
            requests: planned waypoint by vehicle id.
            tasks: tasks whose vehicles may be moved; one that has got another task since it was planned is held.
            returning: the vehicles return, which a low battery must not prevent.
        """
        situation = self.situation(requests, tasks, returning=returning)
        # Without the surface no waypoint is in a layer: what is asked for is a place of its own.
        bounds, surface = self._bounds, self._roster.layers.surface or LEVEL
        return vet_plan(requests, situation, bounds.detours, bounds.ground, surface)

    def situation(
        self, vehicle_ids: Iterable[int], tasks: frozenset[Task] = _SWARM, *, returning: bool = False
    ) -> TrafficSituation:
        """Return the present traffic, in which waypoints of these vehicles can be vetted; arguments as for ``vet``.

        Raises:
            RuntimeError: there are no limits yet; a defect of the caller.
        """
        limits, members = self._bounds.in_force, self._roster.select(vehicle_ids)
        movable = tuple(
            self._request(member, position_enu_m, position_enu_m, returning=returning)
            for member in members
            if is_ours(member, tasks) and (position_enu_m := self._roster.position_enu_m(member)) is not None
        )
        return TrafficSituation(
            limits=limits,
            arrival_radius_m=self._settings.arrival_radius_m,
            movable=movable,
            left={member.vehicle_id: why_left(member) for member in members if not is_ours(member, tasks)},
            obstacles=tuple(self._obstacles({request.vehicle_id for request in movable})),
        )

    def accuracy(self, member: Member) -> Accuracy:
        """Return the accuracy of a vehicle's position that paths of others take into account."""
        return accuracy_on_paths(member, self._bounds.in_force.separation_m, self._settings.layer_spacing_m)

    def clearance_m(self, members: Iterable[Member]) -> float:
        """Return how far apart side by side these vehicles have to be, by the least accurate of them."""
        separation_m = self._bounds.in_force.separation_m
        return separation_m + max((beside_errors_m(self.accuracy(one)) for one in members), default=0.0)

    def vet_climbs(self, members: Iterable[Member]) -> dict[int, Refusal]:
        """Return why vehicles on the ground must not climb to their layers, by id; those that may are left out.

        Raises:
            RuntimeError: there are no limits or layers yet; a defect of the caller.
        """
        limits, requests, barred = self._bounds.in_force, [], dict[int, Refusal]()
        for member in members:
            column_enu_m, position_enu_m = self._roster.own_column_enu_m(member), self._roster.position_enu_m(member)
            if column_enu_m is None or position_enu_m is None:
                barred[member.vehicle_id] = Refusal("it has no altitude layer or no position")
                continue
            requests.append(self._request(member, position_enu_m, column_enu_m))
        obstacles = self._obstacles({request.vehicle_id for request in requests})
        vetted = vet_waypoints(requests, obstacles, limits, self._bounds.ground)
        return barred | {
            record.vehicle_id: Refusal(f"it cannot climb to its layer, {record.reason}")
            for record in vetted
            if record.verdict is not WaypointVerdict.SENT
        }

    def _request(
        self,
        member: Member,
        position_enu_m: NDArray[np.float64],
        requested_enu_m: NDArray[np.float64],
        *,
        returning: bool = False,
    ) -> WaypointRequest:
        return WaypointRequest(
            vehicle_id=member.vehicle_id,
            position_enu_m=position_enu_m,
            requested_enu_m=requested_enu_m,
            link_age_s=self._roster.link_age_s(member),
            position_age_s=self._roster.position_age_s(member),
            battery_fraction=None if returning else member.state.battery_fraction,
            home_enu_m=member.home_enu_m,
            battery_per_m=self._battery_per_m(member),
            accuracy=self.accuracy(member),
            waypoint_enu_m=destination_enu_m(member, self._settings),
            stop_enu_m=stop_enu_m(member, position_enu_m, self._roster, self._settings),
        )

    def _obstacles(self, moving_ids: set[int]) -> list[Obstacle]:
        """Return the other airborne vehicles whose positions are known."""
        others = (member for member in self._roster.members() if member.vehicle_id not in moving_ids)
        return [obstacle for member in others if (obstacle := self._obstacle(member)) is not None]

    def _obstacle(self, member: Member) -> Obstacle | None:
        position_enu_m = self._roster.position_enu_m(member)
        if not member.airborne or position_enu_m is None:
            return None
        accuracy, bottom_m = self.accuracy(member), self._bounds.bottom_m
        return obstacle_of(member, position_enu_m, self._roster, self._settings, accuracy=accuracy, bottom_m=bottom_m)

    def rest_of_way(self, member: Member, others: Iterable[Member], tolerance_m: float) -> Admission:
        """Return how much of what is left of a granted way keeps clear of other vehicles, as they are known by now.

        What the vehicle passes before it can stop, braking twice as hard as is assumed elsewhere, does not count:
        no hold keeps it from there, and it might stop right above or below what it has passed.

        Args:
            member: vehicle that flies to a waypoint.
            others: vehicles to keep clear of.
            tolerance_m: distance by which it may be too near to them.
        """
        position_enu_m, end_enu_m = self._roster.position_enu_m(member), destination_enu_m(member, self._settings)
        limits = self._bounds.limits
        if limits is None or position_enu_m is None or end_enu_m is None:
            return ALL_ADMITTED
        obstacles = [obstacle for other in others if (obstacle := self._obstacle(other)) is not None]
        request = self._request(member, position_enu_m, end_enu_m)
        traffic = Traffic([request], obstacles, limits.separation_m - tolerance_m)
        stop = stop_enu_m(member, position_enu_m, self._roster, self._settings)
        start_enu_m = position_enu_m if stop is None else (position_enu_m + stop) / 2.0
        return traffic.admissible(member.vehicle_id, start_enu_m, end_enu_m)

    def blocks_path(
        self,
        member: Member,
        start_enu_m: NDArray[np.float64],
        end_enu_m: NDArray[np.float64],
        ignored: frozenset[int] = frozenset(),
    ) -> int | None:
        """Return the id of a vehicle that is, or may come, too near to straight paths; None if they are free.

        Args:
            member: vehicle that is to fly them; it does not count itself.
            start_enu_m: start of the path, shape (3,), or of each path, (n, 3).
            end_enu_m: end of the path, the same shape.
            ignored: ids of other vehicles that do not count.
        """
        if (limits := self._bounds.limits) is None:
            return None
        for obstacle in self._obstacles({member.vehicle_id} | ignored):
            if obstacle.is_near(start_enu_m, end_enu_m, self.accuracy(member), limits.separation_m):
                return obstacle.vehicle_id
        return None

    def _battery_per_m(self, member: Member) -> float | None:
        per_s = member.battery.per_s
        return None if per_s is None else per_s / self._settings.cruise_speed_mps

    def orders(self, records: Sequence[WaypointRecord], tasks: frozenset[Task] = _SWARM) -> dict[int, Command]:
        """Return the commands that vetted waypoints lead to, by vehicle, and note the waypoints as sent.

        A vehicle that safety has held is told to hold where it still flies to a waypoint that is not for its task.
        None is for a vehicle that has got a task outside of ``tasks`` since it was vetted, or was taken over.
        """
        orders: dict[int, Command] = {}
        for record, member in zip(records, self._roster.select(record.vehicle_id for record in records), strict=True):
            member.keep_back(None if record.verdict is WaypointVerdict.SENT else record.reason)
            if not is_ours(member, tasks):
                continue
            if record.sent_enu_m is not None:
                waypoint_enu_m = np.array(record.sent_enu_m)
                member.send_to(waypoint_enu_m)
                member.turn.order(record.heading_rad, member.state.heading_rad, self._clock.now_s())
                place = self._roster.geodetic(member, waypoint_enu_m)
                speed_mps = record.speed_mps or self._settings.cruise_speed_mps
                orders[member.vehicle_id] = Goto(place, speed_mps, member.turn.heading_rad)
            elif must_stop(member, self._roster.position_enu_m(member), self._settings):
                orders[member.vehicle_id] = member.hold_for_safety()
                if member.task is Task.RETURNING:
                    text = f"must not fly on towards home now, so it hovers and tries again ({record.reason})"
                    self._journal.notice(Severity.WARNING, text, member.vehicle_id)
        return orders

    async def send(
        self,
        records: Sequence[WaypointRecord],
        on_handed_over: Callable[[], None] | None = None,
        tasks: frozenset[Task] = _SWARM,
    ) -> dict[int, Refusal | None]:
        """Send vetted waypoints, as ``orders`` says, and return as ``command_each`` does what became of them."""
        orders = self.orders(records, tasks)
        members = self._roster.select(orders)
        results = await self.command_each(members, lambda one: orders[one.vehicle_id], on_handed_over=on_handed_over)
        return {key: result for key, result in results.items() if not isinstance(orders[key], Hold)}

    def has_arrived(self, member: Member) -> bool:
        """Return whether the vehicle hovers at its waypoint, and heads where it was told to."""
        hovers = hovers_at_waypoint(member, self._roster.position_enu_m(member), self._settings)
        return hovers and member.turn.is_over(self._clock.now_s())

    def _waits(self, member: Member) -> bool:
        """Return whether the vehicle hovers at its waypoint, or was told to hold instead of flying there."""
        return isinstance(member.last_command, Hold) or self.has_arrived(member)

    async def wait_until(
        self, members: Callable[[], Iterable[Member]], done: Callable[[Member], bool], timeout_s: float
    ) -> list[Member]:
        """Wait until ``done`` holds for all ``members()``, asked anew each time; return those left at the deadline."""
        deadline_s = self._clock.now_s() + timeout_s
        while True:
            sign_of_life()
            waiting = [member for member in members() if not done(member)]
            if not waiting or self._clock.now_s() >= deadline_s:
                return waiting
            await self._clock.sleep(_POLL_S)

    async def transfer(
        self,
        requests: Mapping[int, NDArray[np.float64]],
        tasks: frozenset[Task],
        *,
        returning: bool = False,
        left_out: Callable[[int], bool] = lambda _: False,
    ) -> list[Member]:
        """Fly to far waypoints, sent again while safety shortens or holds them; return those not there in time.

        A waypoint in a no-go zone is replaced by the nearest place outside of it.
        Vehicles whose task leaves ``tasks`` on the way, that are taken over, or whose ids ``left_out`` names, are no
        longer waited for.
        """
        deadline_s = self._clock.now_s() + self._deadlines.transfer_s
        places_enu_m = {vehicle_id: self._reachable(place_enu_m) for vehicle_id, place_enu_m in requests.items()}

        def pending() -> list[Member]:
            return [
                member
                for member in self._roster.select(places_enu_m)
                if is_ours(member, tasks)
                and not left_out(member.vehicle_id)
                and not self.is_at(member, places_enu_m[member.vehicle_id])
            ]

        while (members := pending()) and (left_s := deadline_s - self._clock.now_s()) > 0.0:
            planned = {member.vehicle_id: places_enu_m[member.vehicle_id] for member in members}
            results = await self.send(self.vet(planned, tasks, returning=returning), tasks=tasks)
            refused = [vehicle_id for vehicle_id, refusal in results.items() if refusal is not None]
            # A vehicle that refuses is asked again soon, even if others are still on their way.
            wait_s = _RETRY_S if refused else self._deadlines.move_s
            await self.wait_until(pending, self._waits, min(left_s, wait_s))
            await self._clock.sleep(_POLL_S)
        return pending()

    def _reachable(self, place_enu_m: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._bounds.limits is None:
            return place_enu_m
        return self._roster.layers.moved(place_enu_m, self._bounds.detours.reachable(place_enu_m[:2]))

    def is_at(self, member: Member, target_enu_m: NDArray[np.float64]) -> bool:
        """Return whether the vehicle was sent to this very place, shape (3,), and hovers there."""
        waypoint_enu_m = member.waypoint_enu_m
        return waypoint_enu_m is not None and np.array_equal(waypoint_enu_m, target_enu_m) and self.has_arrived(member)


def _name(command: Command) -> str:
    return type(command).__name__.lower()
