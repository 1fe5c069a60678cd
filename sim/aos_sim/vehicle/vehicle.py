"""One vehicle on the MAVLink network: its components, and which message is for which."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.heights import AboveHomeM
from aos_sim.camera.component import CameraComponent, CameraView
from aos_sim.camera.shutter import ShutterCamera
from aos_sim.clock import SimTime
from aos_sim.packets import Packer
from aos_sim.vehicle.autopilot import SimulatedAutopilot
from aos_sim.vehicle.commands import is_addressed_to
from aos_sim.vehicle.kinematics import Kinematics

AUTOPILOT_COMPONENT = int(mavlink.MAV_COMP_ID_AUTOPILOT1)


class SimulatedVehicle:
    """Autopilot and, unless it comes from elsewhere, camera with one system id; parsed messages in, packets out."""

    def __init__(self, autopilot: SimulatedAutopilot, camera: CameraComponent | ShutterCamera | None) -> None:
        self.system_id = autopilot.identity.system_id
        self.autopilot = autopilot
        self.camera = camera
        self._own_components = {AUTOPILOT_COMPONENT} if camera is None else {AUTOPILOT_COMPONENT, camera.COMPONENT_ID}
        self._autopilot_packer = Packer(self.system_id, AUTOPILOT_COMPONENT)
        self._camera_packer = Packer(self.system_id, CameraComponent.COMPONENT_ID)

    def handle(self, message: mavlink.MAVLink_message, kinematics: Kinematics, now: SimTime) -> None:
        """Hand a message to the component it is meant for; others' messages are ignored."""
        if message.get_srcSystem() == self.system_id and message.get_srcComponent() in self._own_components:
            return
        if not is_addressed_to(message, self.system_id, self.autopilot.ACCEPTS_BROADCAST):
            return
        if self.camera is not None and self.camera.answers(message):
            self.camera.handle(message, now)
        elif getattr(message, "target_component", 0) in (0, AUTOPILOT_COMPONENT):
            self.autopilot.handle(message, kinematics, now)

    def update(self, kinematics: Kinematics, now: SimTime) -> None:
        """Advance both components to ``now``, at least one tick later than before."""
        self.autopilot.update(kinematics, now)
        if self.camera is not None:
            self.camera.update(now)

    def view(self) -> CameraView:
        """Return where a camera of this vehicle is now."""
        kinematics = self.autopilot.kinematics
        height_m = AboveHomeM(kinematics.position_enu_m[2] - self.autopilot.flight.home_enu_m[2])
        return CameraView(kinematics.geodetic, height_m, kinematics.heading_rad)

    def drain(self) -> bytes:
        """Return what is to be sent, encoded; empty when there is nothing."""
        packets = [self._autopilot_packer.pack(message) for message in self.autopilot.drain()]
        if self.camera is not None:
            packets += [self._camera_packer.pack(message) for message in self.camera.drain()]
        return b"".join(packets)
