"""Cameras for all vehicles that are heard on some links: sockets, images and the place of the world."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass
from functools import partial

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError, LinkError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.attached.camera import AttachedCamera, Shot
from aos_sim.attached.senders import Sender, SenderTable
from aos_sim.camera.darkroom import Darkroom, check_camera_options
from aos_sim.camera.image import ImageSource
from aos_sim.camera.server import ImageServer
from aos_sim.errors.exposure import Motion
from aos_sim.errors.model import RTK, ErrorModel
from aos_sim.links import Address, Endpoint, LinkAddress, LinkKind, open_endpoint
from aos_sim.report import AttachedCamerasReport, ClearanceMonitor, SeparationMonitor
from aos_sim.world.relief import Relief

_LOGGER = logging.getLogger(__name__)

_TICK_S = 0.02
_RETRY_S = 1.0
_MAX_VEHICLES = 128
"""Greatest number of vehicles on one link."""
_SEPARATION_PERIOD_S = 0.1
_SEPARATION_LAG_S = 0.3
"""Separations are those of a moment ago, of which the poses of all vehicles have arrived."""
_AUTOPILOT_COMPONENT = int(mavlink.MAV_COMP_ID_AUTOPILOT1)


@dataclass(frozen=True, slots=True)
class AttachedOptions:
    """Links of the vehicles, and settings of their cameras.

    Raises:
        ConfigurationError: a value is out of its range.
    """

    links: tuple[str, ...]
    """Connections to the vehicles."""
    gcs: str | None = None
    """Link of the cameras to the ground station; None: through their vehicles."""
    origin: GeodeticPosition | None = None
    """Origin of the world; None: the home of the vehicle with the lowest id that is known at the first exposure."""
    seed: int = 1
    """Seed of the noise in the images."""
    image_size_px: int = 512
    fov_rad: float = math.radians(50.0)
    http_port: int = 0
    """Port of the image server; 0: any free one."""
    errors: ErrorModel = RTK
    """Errors of the cameras; those of positions, attitudes and the wind that moves vehicles are the vehicles' own."""

    def __post_init__(self) -> None:
        check_camera_options(self.image_size_px, self.fov_rad, self.http_port)
        if not self.links:
            raise ConfigurationError("At least one --link to the vehicles is needed.")
        for link in self.links:
            if LinkAddress.parse(link).kind is LinkKind.UDP_OUT:
                raise ConfigurationError(
                    f"--link must be udpin://, tcpout:// or tcpin://, as cameras wait to hear a vehicle; got {link}."
                )
        if self.gcs is not None and LinkAddress.parse(self.gcs).kind not in (LinkKind.UDP_OUT, LinkKind.TCP_OUT):
            raise ConfigurationError(f"--gcs must be udpout:// or tcpout://, the cameras call it; got {self.gcs}.")


class AttachedCameras:
    """The cameras beside all vehicles that are heard, from the first heartbeat on, for as long as :meth:`run` runs.

    Args:
        options: links and cameras.
        source: what the cameras see.
        relief: shape of the ground that the heights of the report count from; None: it is level, and there are none.
    """

    def __init__(self, options: AttachedOptions, source: ImageSource, relief: Relief | None = None) -> None:
        self.frame = LocalFrame(options.origin) if options.origin is not None else None
        """The world's axes; None until its place is known."""
        self._options = options
        size_px = options.image_size_px
        camera_model = CameraModel.from_fov(size_px, size_px, options.fov_rad)
        self._darkroom = Darkroom(source, camera_model, options.errors, options.seed, ImageServer(options.http_port))
        self._gcs = LinkAddress.parse(options.gcs) if options.gcs is not None else None
        self._cameras: dict[int, AttachedCamera] = {}
        self._senders = SenderTable()
        self._links: dict[int, Endpoint] = {}
        self._gcs_links: dict[int, Endpoint] = {}
        self._separation = SeparationMonitor()
        self._relief = relief
        self._clearances: dict[int, ClearanceMonitor] = {}
        """Heights of each vehicle whose launch point is known."""
        self._separation_due_s = 0.0
        self._start_s = time.monotonic()
        self._start_utc_us = time.time_ns() // 1000
        self._group = asyncio.TaskGroup()
        self._gcs_tasks: dict[int, asyncio.Task[None]] = {}
        self._developing: set[asyncio.Task[None]] = set()

    @property
    def start_utc_s(self) -> float:
        """Time since the Unix epoch at which the world began."""
        return self._start_utc_us / 1e6

    def homes_enu_m(self) -> dict[int, tuple[float, float, float]]:
        """Return where each vehicle takes off, by system id, as far as it is known."""
        if self.frame is None:
            return {}
        homes = {system_id: camera.telemetry.home for system_id, camera in sorted(self._cameras.items())}
        return {
            system_id: tuple(self.frame.to_enu(home).tolist()) for system_id, home in homes.items() if home is not None
        }

    def report(self) -> AttachedCamerasReport:
        """Return what the cameras have seen so far."""
        cameras = tuple(camera.report() for _, camera in sorted(self._cameras.items()))
        return AttachedCamerasReport(
            min_separation_m=self._separation.smallest_m,
            min_separation_pair=self._separation.pair,
            images=sum(camera.images for camera in cameras),
            cameras=cameras,
            min_height_above_ground_m=min(
                (one.smallest_m for one in self._clearances.values() if one.smallest_m is not None), default=None
            ),
        )

    async def run(self) -> None:
        """Serve until cancelled.

        Raises:
            LinkError: a port is taken.
        """
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self._darkroom)
            addresses = dict(enumerate(map(LinkAddress.parse, self._options.links)))
            for number, address in addresses.items():
                if address.kind is not LinkKind.TCP_OUT:
                    self._links[number] = await open_endpoint(address, partial(self._receive, number), _MAX_VEHICLES)
                    stack.callback(self._links[number].close)
            self._group = await stack.enter_async_context(asyncio.TaskGroup())
            for number, address in addresses.items():
                if address.kind is LinkKind.TCP_OUT:
                    self._group.create_task(self._keep_open(address, self._links, number, self._receive))
            while True:
                self._tick(self._now_s())
                await asyncio.sleep(_TICK_S)

    # --- links -------------------------------------------------------------------------------------------------------

    async def _keep_open(
        self,
        address: LinkAddress,
        links: dict[int, Endpoint],
        key: int,
        receive: Callable[[int, mavlink.MAVLink_message, Address], None],
    ) -> None:
        """Have the endpoint of a link that calls out in ``links``, opened again whenever it is lost."""
        is_told = False
        while True:
            try:
                endpoint = await open_endpoint(address, partial(receive, key))
            except LinkError as error:
                if not is_told:
                    _LOGGER.info("%s Retrying.", error)
                is_told = True
                await asyncio.sleep(_RETRY_S)
                continue
            links[key] = endpoint
            is_told = False
            try:
                await endpoint.wait_until_lost()
            finally:
                del links[key]
                endpoint.close()
            _LOGGER.warning("%s lost; reconnecting.", address)

    def _receive(self, link: int, message: mavlink.MAVLink_message, address: Address) -> None:
        """Take a message from a vehicle's link: of its autopilot, or passed on by it."""
        now_s, sender = self._now_s(), Sender(link, address)
        system_id = message.get_srcSystem()
        if system_id not in self._cameras and _is_autopilot_heartbeat(message):
            self._cameras[system_id] = AttachedCamera(
                system_id, message.autopilot, self._darkroom.camera, self._start_utc_us
            )
            _LOGGER.info("vehicle %d is heard at %s", system_id, sender)
        if system_id in self._cameras and message.get_srcComponent() == _AUTOPILOT_COMPONENT:
            self._hear(self._cameras[system_id], message, sender, now_s)
        elif self._gcs is None:
            camera = self._cameras.get(getattr(message, "target_system", 0))
            if camera is not None and self._senders.sender_of(camera.system_id) == sender:
                camera.command(message, now_s)

    def _receive_from_gcs(self, system_id: int, message: mavlink.MAVLink_message, _address: Address) -> None:
        self._cameras[system_id].command(message, self._now_s())

    def _hear(self, camera: AttachedCamera, message: mavlink.MAVLink_message, sender: Sender, now_s: float) -> None:
        was_ambiguous = self._senders.is_ambiguous(camera.system_id, now_s)
        if self._senders.hear(camera.system_id, sender, now_s):
            camera.hear(message, now_s)
        elif not was_ambiguous:
            _LOGGER.error(
                "system id %d is heard from %s and from %s: its images are refused; "
                "give each vehicle its own id and name one --link per vehicle",
                camera.system_id,
                self._senders.sender_of(camera.system_id),
                sender,
            )

    # --- cameras -----------------------------------------------------------------------------------------------------

    def _tick(self, now_s: float) -> None:
        for system_id, camera in self._cameras.items():
            if self._gcs is not None and system_id not in self._gcs_tasks:
                keeping_open = self._keep_open(self._gcs, self._gcs_links, system_id, self._receive_from_gcs)
                self._gcs_tasks[system_id] = self._group.create_task(keeping_open)
            camera.poll(now_s)
            for shot in camera.take_shots():
                self._take(camera, shot, now_s)
            self._flush(camera, now_s)
        if now_s >= self._separation_due_s:
            self._separation_due_s = now_s + _SEPARATION_PERIOD_S
            self._watch_positions(now_s)

    def _take(self, camera: AttachedCamera, shot: Shot, now_s: float) -> None:
        frame = self.frame or self._place_world()
        if self._senders.is_ambiguous(camera.system_id, now_s):
            camera.refuse(shot.exposure, "its system id is used by two senders")
        elif frame is None:
            camera.refuse(shot.exposure, "no vehicle has reported its home, the origin of the world")
        else:
            task = self._group.create_task(self._develop(camera, shot, frame))
            self._developing.add(task)
            task.add_done_callback(self._developing.discard)

    def _place_world(self) -> LocalFrame | None:
        homes = {key: home for key, camera in self._cameras.items() if (home := camera.telemetry.home) is not None}
        if homes:
            first = min(homes)
            self.frame = LocalFrame(homes[first])
            _LOGGER.info("the world's origin is the home of vehicle %d: %s", first, homes[first])
        return self.frame

    async def _develop(self, camera: AttachedCamera, shot: Shot, frame: LocalFrame) -> None:
        true = shot.pose.true
        velocity_enu_mps = np.array(shot.pose.velocity_enu_mps)
        motion = Motion(frame.to_enu(true.position), true.heading_rad, velocity_enu_mps)
        url = await self._darkroom.develop(shot.exposure, motion)
        camera.deliver(shot, url)
        self._flush(camera, self._now_s())

    def _flush(self, camera: AttachedCamera, now_s: float) -> None:
        sender = self._senders.sender_of(camera.system_id)
        self._send(self._links.get(sender.link), camera.requests(now_s), sender.address)
        if self._gcs is None:
            self._send(self._links.get(sender.link), camera.drain(), sender.address)
        else:
            self._send(self._gcs_links.get(camera.system_id), camera.drain())

    def _send(self, endpoint: Endpoint | None, data: bytes, to: Address | None = None) -> None:
        if endpoint is not None and data:
            endpoint.send(data, to)

    def _watch_positions(self, now_s: float) -> None:
        positions = {}
        for system_id, camera in self._cameras.items():
            moment_s = camera.telemetry.vehicle_time_s(now_s - _SEPARATION_LAG_S)
            pose = camera.telemetry.pose_at(moment_s) if moment_s is not None else None
            if pose is not None:
                positions[system_id] = pose.true.position
        if positions:
            about_first = LocalFrame(next(iter(positions.values())))
            positions_m = np.array([about_first.to_enu(place) for place in positions.values()])
            self._separation.update(list(positions), positions_m)
        if self.frame is None or self._relief is None:
            return
        homes_enu_m = self.homes_enu_m()
        for system_id, place in positions.items():
            if system_id in homes_enu_m and system_id not in self._clearances:
                home_enu_m = np.array(homes_enu_m[system_id])[None]
                self._clearances[system_id] = ClearanceMonitor(home_enu_m, self._relief)
            if system_id in self._clearances:
                self._clearances[system_id].update(self.frame.to_enu(place)[None])

    def _now_s(self) -> float:
        return time.monotonic() - self._start_s


def _is_autopilot_heartbeat(message: mavlink.MAVLink_message) -> bool:
    return bool(
        message.get_msgId() == mavlink.MAVLINK_MSG_ID_HEARTBEAT
        and message.get_srcComponent() == _AUTOPILOT_COMPONENT
        and message.autopilot != mavlink.MAV_AUTOPILOT_INVALID
    )
