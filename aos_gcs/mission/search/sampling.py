"""One step's frames: everybody exposes at the same time, and the step goes on without those that do not deliver."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass

from aos_gcs.errors import CaptureError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.fleet.roster import Member
from aos_gcs.ports import Capture


@dataclass(frozen=True, slots=True)
class Sample:
    """What came of one round of exposures."""

    captures: tuple[Capture, ...]
    missing: dict[int, str]
    """Reason by vehicle id."""


async def sample(members: Sequence[Member], deadline_s: float) -> Sample:
    """Expose one frame per vehicle and fetch it, until all are there or the deadline passes."""

    async def capture(member: Member) -> Capture | str:
        try:
            return await member.vehicle.capture(deadline_s)
        except CaptureError as error:
            return str(error)

    async with asyncio.TaskGroup() as group:
        tasks = {member.vehicle_id: group.create_task(capture(member)) for member in members}
    results = {vehicle_id: task.result() for vehicle_id, task in tasks.items()}
    return Sample(
        captures=tuple(result for result in results.values() if isinstance(result, Capture)),
        missing={vehicle_id: result for vehicle_id, result in results.items() if isinstance(result, str)},
    )


def to_frame(capture: Capture, frame: LocalFrame) -> Frame:
    """Place a capture in the mission's ENU frame.

    The axes at the camera and at the origin differ by the angle between their verticals, 0.01 degrees per kilometre.
    """
    return Frame(
        vehicle_id=capture.vehicle_id,
        image=capture.image,
        bands=capture.bands,
        pose=Pose(frame.to_enu(capture.position), capture.R_cam2enu),
        camera=capture.camera,
        time_sigma_s=capture.time_sigma_s,
    )
