"""The MAVSDK driver on a link that loses what matters."""

from __future__ import annotations

import asyncio

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")

from aos_drivers.mavsdk import core, open_mavsdk
from aos_gcs.clock import LoopClock
from aos_gcs.ports import DriverContext
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.fakes.program import unused_port
from tests.fakes.sim_errors import POSITIONS_ERR
from tests.timing import scaled_s

SPEED = 10.0


async def test_a_lost_message_about_an_image_is_asked_for_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """MAVSDK's camera plugin would wait for it forever."""
    about_images: list[bytes] = []
    deliver = core.Feeder.feed

    def lose_first(feeder: core.Feeder, packet: bytes) -> None:
        is_about_image = int.from_bytes(packet[7:10], "little") == mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED
        if is_about_image:
            about_images.append(packet)
        if not is_about_image or len(about_images) > 1:
            deliver(feeder, packet)

    monkeypatch.setattr(core.Feeder, "feed", lose_first)
    port = unused_port()
    clock = LoopClock(SPEED)
    options = SwarmOptions(
        vehicles=1,
        links=(f"udpout://127.0.0.1:{port}",),
        speed=SPEED,
        image_size_px=32,
        start_up_s=2.0,
        errors=POSITIONS_ERR,
    )
    context = DriverContext(clock, lambda: True, lambda _: None)
    async with (
        open_mavsdk([f"udpin://127.0.0.1:{port}"], context) as fleet,
        SimulatedSwarm(options, CheckerboardGround()),
    ):
        async with asyncio.timeout(scaled_s(20.0)):
            while not any(vehicle.state.ready_to_arm for vehicle in fleet.vehicles().values()):
                await clock.sleep(0.5)
        captures = [await fleet.vehicles()[1].capture(clock.now_s() + SPEED * scaled_s(20.0)) for _ in range(2)]
    assert [capture.image_index for capture in captures] == [0, 1]
    # On a busy machine it is asked for several times before the answer comes.
    assert len(about_images) >= 3
