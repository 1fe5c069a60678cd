"""One step's frames: all vehicles expose at the same time, and the step goes on without those that deliver none.

Frames that vehicles expose in flight are those of :mod:`aos_gcs.mission.search.in_flight.exposing`.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from aos_gcs.errors import CaptureError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Capture, Severity

_POLL_S = 0.5
_LOST = "its link was lost before its image came"


@dataclass(frozen=True, slots=True)
class Sample:
    """Result of one round of exposures."""

    captures: tuple[Capture, ...]
    missing: dict[int, str]
    """Reason by vehicle id."""
    speeds_mps: Mapping[int, float] = field(default_factory=dict)
    """Speed at exposure by vehicle id; empty where all hovered."""


async def sample(
    members: Sequence[Member], deadline_s: float, on_capture: Callable[[Capture], Capture] = lambda capture: capture
) -> Sample:
    """Expose one frame per vehicle and fetch it, until the deadline; a vehicle lost meanwhile is not awaited.

    Args:
        members: vehicles to expose.
        deadline_s: time on the clock after which no frame is awaited.
        on_capture: called with each frame as it comes; returns it as it is to be used.
    """

    async def capture(member: Member) -> Capture | str:
        try:
            return on_capture(await member.vehicle.capture(deadline_s))
        except CaptureError as error:
            return str(error)

    async with asyncio.TaskGroup() as group:
        tasks = {member.vehicle_id: group.create_task(capture(member)) for member in members}
        pending = set(tasks.values())
        while pending:
            _, pending = await asyncio.wait(pending, timeout=_POLL_S)
            for member in members:
                if member.task is Task.LOST:
                    tasks[member.vehicle_id].cancel()
    results = {vehicle_id: _LOST if task.cancelled() else task.result() for vehicle_id, task in tasks.items()}
    return Sample(
        captures=tuple(result for result in results.values() if isinstance(result, Capture)),
        missing={vehicle_id: result for vehicle_id, result in results.items() if isinstance(result, str)},
    )


def to_frame(capture: Capture, frame: LocalFrame, speed_mps: float = 0.0) -> Frame:
    """Place a capture in the mission's ENU frame, with the speed of its vehicle at exposure.

    The axes at the camera and at the origin differ by the angle between their verticals, 0.01 degrees per kilometre.
    """
    return Frame(
        vehicle_id=capture.vehicle_id,
        image=capture.image,
        bands=capture.bands,
        pose=Pose(frame.to_enu(capture.position), capture.R_cam2enu),
        camera=capture.camera,
        time_sigma_s=capture.time_sigma_s,
        speed_mps=speed_mps,
    )


def without(taken: Sample, reasons: Mapping[int, str]) -> Sample:
    """Return the sample without the frames of some vehicles, which are missing for these reasons."""
    captures = tuple(capture for capture in taken.captures if capture.vehicle_id not in reasons)
    return replace(taken, captures=captures, missing=taken.missing | dict(reasons))


class Sampler:
    """Takes the frames of each step and reports the vehicles that it goes on without."""

    def __init__(self, context: FlightContext) -> None:
        self._context = context

    async def take(self, step: int, swarm: Sequence[Member], on_capture: Callable[[Capture], None]) -> Sample:
        """Take the frames of the vehicles that hover; frames of others would blur.

        Args:
            step: number of the step.
            swarm: vehicles of the swarm.
            on_capture: called with each frame as it comes.
        """
        context = self._context
        deadline_s = context.clock.now_s() + context.settings.deadlines.capture_s
        unsteady = self._unsteady(swarm)
        while len(unsteady) == len(swarm) and context.clock.now_s() < deadline_s:
            sign_of_life()
            await context.clock.sleep(_POLL_S)
            unsteady = self._unsteady(swarm)
        hovering = [member for member in swarm if member.vehicle_id not in unsteady]
        sign_of_life(context.settings.deadlines.capture_s)

        def receive(capture: Capture) -> Capture:
            placed = self.above_datum(capture)
            on_capture(placed)
            return placed

        taken = await sample(hovering, max(deadline_s, context.clock.now_s() + _POLL_S), receive)
        sign_of_life(WORK_S)
        return self.leave_out(step, Sample(taken.captures, {}), unsteady | taken.missing)

    def above_datum(self, capture: Capture) -> Capture:
        """Return a capture with its altitude above the datum that all vehicles share."""
        (member,) = self._context.roster.select([capture.vehicle_id])
        return replace(capture, position=self._context.roster.above_datum(member, capture.position))

    def leave_out(self, step: int, taken: Sample, reasons: Mapping[int, str]) -> Sample:
        """Return the sample without the frames of some vehicles, and report why."""
        for vehicle_id, reason in reasons.items():
            text = f"step {step} goes on without its frame: {reason}"
            self._context.journal.notice(Severity.WARNING, text, vehicle_id)
        return without(taken, reasons)

    def _unsteady(self, swarm: Sequence[Member]) -> dict[int, str]:
        """Return the vehicles that do not hover, or do not report it, with the reason by id."""
        return {member.vehicle_id: refusal.text for member in swarm if (refusal := self._refusal(member)) is not None}

    def why_not_placed(self, member: Member) -> Refusal | None:
        """Return why it is not known where a vehicle is; None if it is."""
        limits, age_s = self._context.bounds.limits, self._context.roster.position_age_s(member)
        if age_s is None or (limits is not None and age_s > limits.max_position_age_s):
            return Refusal("no position yet" if age_s is None else f"its last position is {age_s:.1f} s old")
        return None

    def _refusal(self, member: Member) -> Refusal | None:
        if (refusal := self.why_not_placed(member)) is not None:
            return refusal
        velocity_enu_mps = member.state.velocity_enu_mps
        speed_mps = 0.0 if velocity_enu_mps is None else float(np.linalg.norm(velocity_enu_mps))
        if speed_mps > 2 * self._context.settings.flight.arrival_speed_mps:
            return Refusal(f"still moving at {speed_mps:.1f} m/s")
        return None
