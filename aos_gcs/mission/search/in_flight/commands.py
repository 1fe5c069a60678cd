"""Commands of a line that flies on: what each vehicle is sent, where they stop, and the watch of their age."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.search.frames.sampling import Sample
from aos_gcs.mission.search.in_flight.exposing import Exposures
from aos_gcs.ports import Command, Goto, Hold, Severity

ANALYSIS_S = 1.0
"""Time for a round's analysis. A sweep whose waypoints are older than by this and the longest wait for frames stops:
what was free when they were vetted may no longer be."""
_SAME_PLACE_M = 0.05
_POLL_S = 0.25


def places_to_stop(context: FlightContext, members: Sequence[Member]) -> tuple[WaypointRecord, ...]:
    """Return the places where vehicles of the swarm come to a stop, vetted."""
    flight = context.flight
    situation = flight.situation([member.vehicle_id for member in members])
    return flight.vet(
        {one.vehicle_id: one.position_enu_m if one.stop_enu_m is None else one.stop_enu_m for one in situation.movable}
    )


class SweepCommands:
    """See :class:`aos_gcs.mission.search.step_work.SweepFlight`. No vehicle waits for the confirmation of another.

    Args:
        context: context of the flight.
        exposures: own the tasks that send.
        members: returns the vehicles that sweep, as they are now.
    """

    def __init__(self, context: FlightContext, exposures: Exposures, members: Callable[[], Sequence[Member]]) -> None:
        self._context = context
        self._exposures = exposures
        self._members = members
        self._sending: dict[int, asyncio.Task[None]] = {}
        self._unconfirmed: set[int] = set()
        self.is_on_its_way = False
        """Whether the vehicles fly to waypoints far ahead."""
        self.vetted_at_s = -math.inf
        """Time at which these were vetted."""

    @property
    def is_behind(self) -> bool:
        """Whether frames wait for analysis."""
        return self._exposures.is_behind

    def leave_out(self, step: int, taken: Sample, reasons: Mapping[int, str]) -> Sample:
        """Return the sample without the frames of some vehicles, and report why."""
        return self._exposures.leave_out(step, taken, reasons)

    def send(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Send vetted waypoints while others work."""
        self.is_on_its_way, self.vetted_at_s = True, self._context.clock.now_s()
        self._send_changed(waypoints)

    def stop(self) -> None:
        """Send the vehicles to where they come to a stop."""
        self.is_on_its_way = False
        self._send_changed(places_to_stop(self._context, self._members()))

    async def watch(self, step: Callable[[], int]) -> None:
        """Stop the vehicles where a step takes longer, as when images are not analysed; its decision sends them on.

        Args:
            step: returns the number of the present step.
        """
        clock, journal = self._context.clock, self._context.journal
        longest_s = self._exposures.blind_s + ANALYSIS_S
        while True:
            await clock.sleep(_POLL_S)
            unvetted_s = clock.now_s() - self.vetted_at_s
            if self.is_on_its_way and unvetted_s > longest_s:
                text = f"Step {step()} takes longer than {unvetted_s:.0f} s: the line stops until it is over"
                journal.notice(Severity.WARNING, text)
                self.stop()

    def send_all(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Send vetted waypoints of a close look, also those that are flown to already: the heading may be another."""
        self._start(waypoints)

    def _send_changed(self, waypoints: Sequence[WaypointRecord]) -> None:
        """Send each vehicle what differs from what it was told last; that is no longer repeated."""
        self._start([one for one in waypoints if one.vehicle_id in self._unconfirmed or not self._is_followed(one)])

    def _start(self, waypoints: Sequence[WaypointRecord]) -> None:
        for vehicle_id, command in self._context.flight.orders(waypoints).items():
            self._call_off(vehicle_id)
            self._unconfirmed.discard(vehicle_id)
            # The task is the command itself: one that began it later would overtake an operator's hold.
            self._sending[vehicle_id] = self._exposures.start(self._send(vehicle_id, command))

    def _is_followed(self, waypoint: WaypointRecord) -> bool:
        """Return whether a vehicle flies, or is being sent, to a waypoint already, at its speed."""
        (member,) = self._context.roster.select([waypoint.vehicle_id])
        command = member.last_command
        if waypoint.sent_enu_m is None or member.waypoint_enu_m is None or not isinstance(command, Goto):
            return False
        is_there = bool(np.allclose(member.waypoint_enu_m, waypoint.sent_enu_m, atol=_SAME_PLACE_M))
        return is_there and command.speed_mps == waypoint.speed_mps

    def _call_off(self, vehicle_id: int) -> None:
        if (sending := self._sending.pop(vehicle_id, None)) is not None:
            sending.cancel()

    def give_way(self) -> None:
        """Send no more: the vehicles are about to be sent elsewhere."""
        self.is_on_its_way = False
        for vehicle_id in tuple(self._sending):
            self._call_off(vehicle_id)

    async def finish(self) -> None:
        """Expose no more in flight."""
        await self._exposures.finish()

    async def _send(self, vehicle_id: int, command: Command) -> None:
        (member,) = self._context.roster.select([vehicle_id])
        if await self._context.flight.command(member, command) is not None and not isinstance(command, Hold):
            self._unconfirmed.add(vehicle_id)
