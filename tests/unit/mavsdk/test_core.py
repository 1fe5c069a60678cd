"""Messages on their way through MAVSDK's JSON, and callbacks on their way to the loop."""

from __future__ import annotations

import asyncio
import math
import threading

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")

from aos_drivers.mavsdk import open_mavsdk
from aos_drivers.mavsdk.core import LoopDispatcher, direct_from_message, message_from_direct
from aos_gcs.clock import LoopClock
from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import DriverContext


def test_a_goto_survives_the_json_with_its_nan() -> None:
    where = (483, -143, 270.5)
    frame, command = mavlink.MAV_FRAME_GLOBAL_INT, mavlink.MAV_CMD_DO_REPOSITION
    goto = mavlink.MAVLink_command_int_message(7, 1, frame, command, 0, 0, 5.0, 1.0, 0.0, math.nan, *where)
    direct = direct_from_message(goto, 7, 1)
    assert (direct.message_name, direct.target_system_id, direct.target_component_id) == ("COMMAND_INT", 7, 1)
    assert "NaN" not in direct.fields_json
    back = message_from_direct(direct)
    assert math.isnan(back.param4)
    assert (back.command, back.x, back.y, back.z) == (command, *where)


async def test_callbacks_of_other_threads_run_on_the_loop_until_closed() -> None:
    dispatcher = LoopDispatcher()
    calls: list[tuple[str, threading.Thread]] = []
    callback = dispatcher.to_loop(lambda value: calls.append((value, threading.current_thread())))
    await asyncio.to_thread(callback, "first", None)
    await asyncio.sleep(0)
    assert calls == [("first", threading.current_thread())]
    thread = threading.Thread(target=callback, args=("on its way", None))
    thread.start()
    thread.join()
    dispatcher.close()
    await asyncio.to_thread(callback, "late", None)
    await asyncio.sleep(0)
    assert len(calls) == 1


@pytest.mark.parametrize(
    ("links", "reason"),
    [
        ([], "at least one link"),
        (["carrier-pigeon://roof"], "carrier-pigeon"),
        (["udpin://127.0.0.1:14550?sign=/etc/key"], "cannot sign; use the driver mavlink"),
    ],
)
async def test_links_that_cannot_be_used_are_refused_in_words(links: list[str], reason: str) -> None:
    context = DriverContext(LoopClock(), lambda: True, lambda _: None)
    with pytest.raises(ConfigurationError, match=reason):
        async with open_mavsdk(links, context):
            pass
