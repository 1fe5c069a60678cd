"""Inspection of vehicles before they start: what telemetry does not show, their settings, geofence and a frame.

A vehicle is asked once, again when something about it has changed, every few seconds while an answer is not good, and
now and then while all are (``preflight.refresh_s``). Vehicles that have been started are not asked any more.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.airspace.geofence import vehicle_fence
from aos_gcs.errors import CaptureError, CommandError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.mission.context import FlightContext, MissionContext
from aos_gcs.mission.fleet.landing.return_heights import ReturnHeights
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Capture, Geofence, VehicleFacts, VehicleState

RETRY_S = 5.0
"""Time before a vehicle is asked again whose answer was not good, or missing."""
MAX_FRAME_DISTANCE_M = 15.0
"""Largest distance of a test frame's pose from the vehicle's position; both come from the same receiver."""
_POLL_S = 0.5
_QUESTIONS = 4.0
"""Deadline of an inspection, in deadlines of one command."""
_MAX_HEARD_AGO_S = 3.0
_FRESH_S = 2.0 * RETRY_S
"""Age up to which settings that were read before a vehicle was confirmed need not be read again first."""
_SAME_HEIGHT_M = 0.05
"""Largest difference of equal heights: autopilots store centimetres, or 32-bit floats."""


@dataclass(frozen=True, slots=True)
class TrialFrame:
    """Properties of a test frame."""

    width_px: int
    height_px: int
    bands: tuple[str, ...]
    position: GeodeticPosition
    """Position of its pose."""
    below_horizon_rad: float
    """Angle of the optical axis; pi/2 looks straight down."""
    is_rotation: bool
    """Whether the orientation is a rotation at all."""

    def distance_m(self, state: VehicleState) -> float | None:
        """Return the horizontal distance from the vehicle's reported position; None while it has not reported one."""
        if state.position is None:
            return None
        return float(np.linalg.norm(LocalFrame(self.position).to_enu(state.position)[:2]))

    def is_plausible(self, state: VehicleState) -> bool:
        """Return whether its pose can be that of this vehicle."""
        distance_m = self.distance_m(state)
        return self.is_rotation and (distance_m is None or distance_m <= MAX_FRAME_DISTANCE_M)


@dataclass(frozen=True, slots=True)
class Inspection:
    """Answers of one vehicle so far, and why the rest is missing."""

    facts: VehicleFacts | None = None
    problem: str = ""
    """Reason why its settings could not be read; empty while nothing went wrong."""
    frame: TrialFrame | None = None
    frame_problem: str = ""
    planned_fence: Geofence | None = None
    """Geofence that it should have; None while the limits are not known."""
    may_upload: bool = False
    """Whether the planned geofence is uploaded where another one, or none, is stored."""
    upload_problem: str = ""
    wanted_return_m: AboveHomeM | None = None
    """Failsafe return height above home that it is to have; None: it is left unchanged."""
    return_problem: str = ""

    @property
    def has_planned_fence(self) -> bool:
        """Whether the vehicle stores the planned geofence."""
        stored = None if self.facts is None else self.facts.fence
        return stored is not None and self.planned_fence is not None and stored.is_same_as(self.planned_fence)

    @property
    def has_wanted_return(self) -> bool:
        """Whether the vehicle has the failsafe return height that it should have, or may have any."""
        facts, wanted_m = self.facts, self.wanted_return_m
        if wanted_m is None:
            return True
        return (
            facts is not None and not facts.return_climb_m and abs(facts.return_height_m - wanted_m) <= _SAME_HEIGHT_M
        )

    def is_good(self, state: VehicleState) -> bool:
        """Return whether asking again soon would not change the result."""
        facts = self.facts
        if facts is None or self.problem or self.frame is None or not self.frame.is_plausible(state):
            return False
        safeguards = (
            facts.link_loss,
            facts.low_battery,
            facts.other_failsafes,
            facts.arming_checks,
            facts.return_place,
            facts.at_fence,
        )
        return all(each.is_on for each in safeguards) and self.has_planned_fence and self.has_wanted_return


@dataclass(slots=True)
class _Subject:
    """One vehicle that is being inspected."""

    inspection: Inspection = Inspection()
    due_s: float = -math.inf
    read_s: float = -math.inf
    """Time after which the settings of a vehicle not confirmed yet were read; -inf where they have to be read again."""
    situation: object = None
    """State of the vehicle whose change calls for another inspection."""
    task: asyncio.Task[None] | None = None


class Inspector:
    """Keeps the inspections of all vehicles that have not been started up to date.

    Args:
        context: context of the mission.
        settings: settings of the mission; those used here are no part of a plan.
        return_heights: sets the vehicles' return heights.
        flight: returns the context of the present plan.
    """

    def __init__(
        self,
        context: MissionContext,
        settings: MissionSettings,
        return_heights: ReturnHeights,
        flight: Callable[[], FlightContext],
    ) -> None:
        self._context = context
        self._preflight = settings.preflight
        self._deadlines = settings.deadlines
        self._return_heights = return_heights
        self._flight = flight
        self._subjects: dict[int, _Subject] = {}
        self._starting_again: set[int] = set()
        """Vehicles that have landed and are about to fly once more."""

    def inspection(self, vehicle_id: int) -> Inspection:
        """Return the answers of a vehicle so far."""
        subject = self._subjects.get(vehicle_id)
        return Inspection() if subject is None else subject.inspection

    async def run(self) -> None:
        """Inspect the vehicles that are due, all at the same time, until cancelled."""
        clock = self._context.clock
        async with asyncio.TaskGroup() as group:
            while True:
                for member in self._before_their_start():
                    subject = self._subjects.setdefault(member.vehicle_id, _Subject())
                    is_asked = subject.task is not None and not subject.task.done()
                    if not is_asked and self._may_be_asked(member) and self._is_due(member, subject):
                        subject.task = group.create_task(self._ask(member, subject))
                await clock.sleep(_POLL_S)

    async def settle(self, member: Member) -> None:
        """Wait until a vehicle has geofence and failsafe return height of its new layer, or has refused them.

        A test frame from before its former flight is captured anew.
        """
        clock, until_s = self._context.clock, self._deadline_s()
        subject = self._subjects.setdefault(member.vehicle_id, _Subject())
        frame = subject.inspection.frame
        if frame is not None and not frame.is_plausible(member.state):
            # It was captured before the vehicle flew elsewhere.
            subject.inspection = replace(subject.inspection, frame=None, frame_problem="")
            subject.due_s = -math.inf
        self._starting_again.add(member.vehicle_id)
        try:
            while not self._is_settled(member) and clock.now_s() < until_s:
                await clock.sleep(_POLL_S)
        finally:
            self._starting_again.discard(member.vehicle_id)

    def _is_settled(self, member: Member) -> bool:
        found, wanted_m = self.inspection(member.vehicle_id), self._wanted_return_m(member)
        has_return = found.wanted_return_m == wanted_m and (found.has_wanted_return or bool(found.return_problem))
        is_asked = found.planned_fence is not None and found.planned_fence == self._planned_fence(member)
        has_fence = is_asked and (found.has_planned_fence or bool(found.upload_problem))
        is_captured = found.facts is None or found.frame is not None or bool(found.frame_problem)
        return is_captured and (wanted_m is None or has_return) and (not self._preflight.upload_fence or has_fence)

    def _before_their_start(self) -> list[Member]:
        members = self._context.roster.members(Task.IDLE, Task.LANDED)
        return [m for m in members if m.task is Task.IDLE or m.vehicle_id in self._starting_again]

    def _may_be_asked(self, member: Member) -> bool:
        state, link_age_s = member.state, self._context.roster.link_age_s(member)
        is_heard = link_age_s is not None and link_age_s <= _MAX_HEARD_AGO_S
        return is_heard and not state.armed and not state.is_ambiguous and state.autopilot != "unknown"

    def _is_due(self, member: Member, subject: _Subject) -> bool:
        fence = self._planned_fence(member)
        return_m = self._wanted_return_m(member)
        is_new = subject.inspection.planned_fence != fence
        may_upload = self._preflight.upload_fence
        subject.inspection = replace(subject.inspection, planned_fence=fence, may_upload=may_upload)
        if subject.inspection.wanted_return_m != return_m:
            is_new = True
            subject.inspection = replace(subject.inspection, wanted_return_m=return_m, return_problem="")
        state = member.state
        situation = (state.autopilot, state.home is None, None if state.link is None else state.link.address)
        if situation != subject.situation:
            subject.situation = situation
            subject.read_s = -math.inf
            return True
        return is_new or self._context.clock.now_s() >= subject.due_s

    def _planned_fence(self, member: Member) -> Geofence | None:
        limits, frame, home = self._flight().bounds.limits, self._context.roster.frame, member.state.home
        if limits is None or frame is None or home is None or not self._is_to_fly(member):
            return None
        home_enu_m = frame.to_enu(home) if member.home_enu_m is None else member.home_enu_m
        return vehicle_fence(limits, frame, float(home_enu_m[2]))

    def _wanted_return_m(self, member: Member) -> AboveHomeM | None:
        return self._return_heights.wanted_m(member) if self._is_to_fly(member) else None

    def _is_to_fly(self, member: Member) -> bool:
        """Return whether it may be given settings: those that are only proposed for the mission keep theirs."""
        return member.takes_part or member.vehicle_id in self._starting_again

    # --- one vehicle --------------------------------------------------------------------------------------------------

    async def _ask(self, member: Member, subject: _Subject) -> None:
        try:
            await asyncio.gather(self._read(member, subject), self._expose(member, subject))
        finally:
            is_good = subject.inspection.is_good(member.state)
            period_s = self._preflight.refresh_s if is_good else RETRY_S
            subject.due_s = self._context.clock.now_s() + period_s

    async def _read(self, member: Member, subject: _Subject) -> None:
        """Read the settings; where one is not as planned and may be changed, change it and read again.

        Those of a vehicle that has just been confirmed were read a moment ago: they are compared, and only changes are
        read back, so that the confirmation takes no longer than they do.
        """
        began_s, is_confirmed = self._context.clock.now_s(), self._is_to_fly(member)
        is_known = is_confirmed and began_s - subject.read_s <= _FRESH_S
        subject.read_s = -math.inf  # once only: who is asked again is read again
        if not is_known:
            await self._inspect(member, subject)
        has_written = [await self._upload_fence(member, subject), await self._set_return_height(member, subject)]
        if any(has_written):
            await self._inspect(member, subject)
        if not is_confirmed and not subject.inspection.problem:
            subject.read_s = began_s

    async def _upload_fence(self, member: Member, subject: _Subject) -> bool:
        """Upload the planned geofence where it may be and is missing; return whether that was done."""
        found, fence = subject.inspection, subject.inspection.planned_fence
        is_open = found.facts is not None and not (found.has_planned_fence and found.facts.at_fence.is_on)
        if not (found.may_upload and is_open and fence is not None):
            return False
        try:
            await member.vehicle.upload_fence(fence, self._deadline_s())
        except CommandError as error:
            subject.inspection = replace(subject.inspection, upload_problem=str(error))
            return False
        subject.inspection = replace(subject.inspection, upload_problem="")
        return True

    async def _set_return_height(self, member: Member, subject: _Subject) -> bool:
        """Set the return height where it is to be changed; return whether that was done."""
        found = subject.inspection
        facts, wanted_m = found.facts, found.wanted_return_m
        problem = ""
        if facts is not None:
            await self._return_heights.adopt(member, facts)
        if facts is None or wanted_m is None or found.has_wanted_return:
            is_done = False
        else:
            try:
                await self._return_heights.set(member, facts, wanted_m, self._deadline_s())
                is_done = True
            except CommandError as error:
                problem, is_done = str(error), False
        subject.inspection = replace(subject.inspection, return_problem=problem)
        return is_done

    async def _inspect(self, member: Member, subject: _Subject) -> None:
        try:
            facts = await member.vehicle.inspect(self._deadline_s())
        except CommandError as error:
            subject.inspection = replace(subject.inspection, problem=str(error))
        else:
            subject.inspection = replace(subject.inspection, facts=facts, problem="")

    async def _expose(self, member: Member, subject: _Subject) -> None:
        """Take a test frame, unless there was a good one already."""
        frame = subject.inspection.frame
        if frame is not None and frame.is_plausible(member.state):
            return
        deadline_s = self._context.clock.now_s() + self._deadlines.capture_s
        try:
            capture = await member.vehicle.capture(deadline_s)
        except CaptureError as error:
            subject.inspection = replace(subject.inspection, frame_problem=str(error))
        else:
            subject.inspection = replace(subject.inspection, frame=_describe(capture), frame_problem="")

    def _deadline_s(self) -> float:
        return self._context.clock.now_s() + _QUESTIONS * self._deadlines.command_s


def _describe(capture: Capture) -> TrialFrame:
    height_px, width_px = capture.image.shape[:2]
    R = capture.R_cam2enu
    is_rotation = bool(np.allclose(R @ R.T, np.eye(3), atol=1e-3) and np.linalg.det(R) > 0)
    below_horizon_rad = math.asin(float(np.clip(-R[2, 2], -1.0, 1.0)))
    return TrialFrame(width_px, height_px, capture.bands, capture.position, below_horizon_rad, is_rotation)
