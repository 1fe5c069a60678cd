"""A camera beside one vehicle, without I/O: messages and times in, packets and images to be made out."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import LocalFrame
from aos_sim.attached.requests import PoseRequests
from aos_sim.attached.telemetry import PoseTelemetry, VehiclePose
from aos_sim.camera.component import CameraComponent, Exposure
from aos_sim.clock import TICK_S, SimTime
from aos_sim.packets import Packer
from aos_sim.report import AttachedCameraReport
from aos_sim.vehicle.commands import is_addressed_to

_LOGGER = logging.getLogger(__name__)

POSE_WAIT_S = 1.0
"""An exposure whose pose has not been told after this time is refused, ..."""
_LEAST_POLLS = 10
"""... but not before so many looks: after a pause of this program, messages may wait unread."""


@dataclass(frozen=True, slots=True)
class Shot:
    """An exposure with its pose: an image to be made."""

    exposure: Exposure
    pose: VehiclePose


@dataclass(slots=True)
class _Waiting:
    """An exposure whose pose is still to come."""

    exposure: Exposure
    moment_s: float | None
    """Time on the vehicle's clock; None if the vehicle has not reported its time."""
    expires_at_s: float
    polls: int = 0


class AttachedCamera:
    """The camera of one vehicle. An exposure takes place when its command arrives.

    Its pose lies between two messages of the vehicle, the second of which is still to come. Policy: an exposure
    without both after ``POSE_WAIT_S`` is refused: announced as failed, counted and logged.

    Args:
        system_id: system id of the vehicle, and of the camera.
        autopilot: the vehicle's MAV_AUTOPILOT.
        camera: the lens and the sensor.
        start_utc_us: microseconds since the Unix epoch at 0 of the times that the methods are given, in seconds.
    """

    def __init__(self, system_id: int, autopilot: int, camera: CameraModel, start_utc_us: int) -> None:
        self.system_id = system_id
        self.telemetry = PoseTelemetry()
        self._max_error_m: float | None = None
        self._start_utc_us = start_utc_us
        self._requests = PoseRequests(system_id, autopilot)
        self._component = CameraComponent(system_id, camera)
        self._packer = Packer(system_id, CameraComponent.COMPONENT_ID)
        self._waiting: list[_Waiting] = []
        self._shots: list[Shot] = []

    def report(self) -> AttachedCameraReport:
        """Return what the camera has done so far."""
        return AttachedCameraReport(
            system_id=self.system_id,
            images=self._component.image_count,
            refused=self._component.failed_count,
            tells_true_pose=self.telemetry.tells_truth,
            max_position_error_m=self._max_error_m,
        )

    def hear(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Take in a message of the vehicle's autopilot."""
        self._requests.hear(message.get_msgId(), now_s)
        self.telemetry.hear(message, now_s)

    def command(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Take in a message from a ground station; what is not for the camera is ignored."""
        if is_addressed_to(message, self.system_id, accepts_broadcast=True) and self._component.answers(message):
            self._component.handle(message, self._sim_time(now_s))
            self._note_exposures(now_s)

    def poll(self, now_s: float) -> None:
        """Do what is due; call it several times in ``POSE_WAIT_S``."""
        self._component.update(self._sim_time(now_s))
        self._note_exposures(now_s)
        for waiting in tuple(self._waiting):
            waiting.polls += 1
            pose = self.telemetry.pose_at(waiting.moment_s) if waiting.moment_s is not None else None
            if pose is not None:
                self._shots.append(Shot(waiting.exposure, pose))
                self._waiting.remove(waiting)
            elif now_s >= waiting.expires_at_s and waiting.polls >= _LEAST_POLLS:
                self._waiting.remove(waiting)
                self.refuse(waiting.exposure, f"the vehicle has not reported its pose for {POSE_WAIT_S:g} s")

    def take_shots(self) -> list[Shot]:
        """Return the images to be made; report each with :meth:`deliver` or :meth:`refuse`."""
        shots, self._shots = self._shots, []
        return shots

    def deliver(self, shot: Shot, file_url: str) -> None:
        """Announce an image."""
        true, believed = shot.pose.true.position, shot.pose.believed.position
        error_m = float(np.linalg.norm(LocalFrame(true).to_enu(believed)))
        self._max_error_m = max(error_m, self._max_error_m or 0.0)
        self._component.image_ready(shot.exposure, shot.pose.believed, file_url)

    def refuse(self, exposure: Exposure, reason: str) -> None:
        """Announce that there is no image of an exposure."""
        _LOGGER.warning("vehicle %d: image %d is refused: %s", self.system_id, exposure.index, reason)
        self._component.image_failed(exposure)

    def requests(self, now_s: float) -> bytes:
        """Return the packets to be sent to the vehicle now."""
        return b"".join(map(self._packer.pack, self._requests.due(now_s)))

    def drain(self) -> bytes:
        """Return the packets to be sent to ground stations and forget them."""
        return b"".join(map(self._packer.pack, self._component.drain()))

    def _note_exposures(self, now_s: float) -> None:
        moment_s = self.telemetry.vehicle_time_s(now_s)
        self._waiting += [
            _Waiting(exposure, moment_s, now_s + POSE_WAIT_S) for exposure in self._component.take_exposures()
        ]

    def _sim_time(self, now_s: float) -> SimTime:
        return SimTime(int(now_s / TICK_S), self._start_utc_us)
