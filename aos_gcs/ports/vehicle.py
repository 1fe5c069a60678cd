"""One vehicle with a camera."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from typing import Protocol

from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.ports.capture import Capture, IntervalCaptures
from aos_gcs.ports.commands import Command
from aos_gcs.ports.setup import Geofence, VehicleFacts
from aos_gcs.ports.telemetry import VehicleState


class Vehicle(Protocol):
    """One vehicle with a camera.

    A vehicle that does not answer blocks no call: each ends by its deadline, with ``CommandTimeoutError`` or, for
    ``capture``, with ``CaptureError``. To a vehicle that has been silent for some seconds, ``execute`` sends ``Hold``,
    ``ReturnToLaunch`` and ``Land`` only, which then time out; other commands are refused at once.
    """

    @property
    def state(self) -> VehicleState:
        """The latest telemetry. Policy: latest value, older ones are replaced."""
        ...

    async def execute(self, command: Command, deadline_s: float) -> None:
        """Carry the command out: acknowledged, repeated when lost, and confirmed by telemetry.

        Commands are never queued behind one another: a newer one for the same vehicle supersedes an older one that is
        still waiting for confirmation, and the older call raises ``CommandRefusedError``.

        Raises:
            CommandRefusedError: the autopilot said no, or the driver must not send it: to a vehicle in a failsafe,
                only ``ReturnToLaunch`` and ``Land``; to one that was taken over, none that arms or moves it. A
                take-over also ends commands that are still waiting.
            CommandTimeoutError: no acknowledgement or no visible effect by ``deadline_s``.
        """
        ...

    def reclaim(self) -> None:
        """Count the vehicle's present mode and target as ours, so that ``state.taken_over`` ends.

        Sends nothing. For an operator who gives a vehicle back to this station after a pilot, another station or the
        autopilot itself took it over.
        """
        ...

    async def inspect(self, deadline_s: float) -> VehicleFacts:
        """Read how the vehicle is set up. Costs a few dozen messages; nothing is changed.

        Raises:
            CommandRefusedError: the vehicle must not be asked, or refuses to answer.
            CommandTimeoutError: not all answers came by ``deadline_s``.
        """
        ...

    async def upload_fence(self, fence: Geofence, deadline_s: float) -> None:
        """Replace the vehicle's geofence, enable it, and read back what is stored.

        Raises:
            CommandRefusedError: the vehicle does not take it, or stores another one.
            CommandTimeoutError: not done by ``deadline_s``.
        """
        ...

    async def set_return_height(self, height_above_home_m: AboveHomeM, deadline_s: float) -> None:
        """Set the height to which the vehicle climbs before its own return; only on the ground.

        A vehicle that is higher returns as high as it is. The vehicle has repeated the new values when this returns.

        Raises:
            CommandRefusedError: its motors run, or it keeps other values.
            CommandTimeoutError: not done by ``deadline_s``.
        """
        ...

    async def restore_return(self, settings: Mapping[str, float], deadline_s: float) -> None:
        """Set back ``VehicleFacts.return_settings`` that were read earlier; only on the ground.

        Raises:
            CommandRefusedError: its motors run, it keeps other values, or a setting does not concern its return.
            CommandTimeoutError: not done by ``deadline_s``.
        """
        ...

    async def capture(self, deadline_s: float) -> Capture:
        """Expose one image now and fetch it.

        Raises:
            CaptureError: the camera refused, or no complete image with a pose arrived by ``deadline_s``.
        """
        ...

    def interval(self, period_s: float, deadline_s: float) -> AbstractAsyncContextManager[IntervalCaptures]:
        """Have the camera take an image every ``period_s`` by itself, for as long as the context is entered.

        Leaving it stops the camera, which takes one second at most; a camera that does not answer is reported.
        Meanwhile ``capture`` fails.

        Raises:
            NoIntervalError: the camera cannot, or refuses: request single images.
            CaptureError: it has not begun by ``deadline_s``.
        """
        ...
