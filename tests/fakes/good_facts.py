"""Settings of a vehicle with which nothing is wrong."""

from __future__ import annotations

from aos_gcs.ports import Safeguard, VehicleFacts

GOOD_FACTS = VehicleFacts(
    firmware="4.7.0",
    board_id="",
    link_loss=Safeguard(True, "return after 5 s"),
    low_battery=Safeguard(True, "return at 20 %"),
    arming_checks=Safeguard(True, "all"),
    other_failsafes=Safeguard(True, "land"),
    return_place=Safeguard(True, "its launch point"),
    fence=None,
    at_fence=Safeguard(True, "return"),
    return_height_m=30.0,
    return_climb_m=0.0,
    return_settings={"RTL_ALT": 3000.0},
)
