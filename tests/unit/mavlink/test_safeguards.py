"""What the settings of an autopilot mean: safeguards, limits, the way home."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.arducopter_setup import ArduCopterSetup
from aos_drivers.vehicle.autopilots.px4_setup import Px4Setup
from aos_drivers.vehicle.parameters.encoding import Parameter
from aos_sim.vehicle.arducopter import ArduCopter
from aos_sim.vehicle.autopilot import SimulatedAutopilot
from aos_sim.vehicle.px4 import Px4

OURS = 254
REAL32 = mavlink.MAV_PARAM_TYPE_REAL32


def parameters(**values: float) -> dict[str, Parameter]:
    return {name: Parameter(value, REAL32) for name, value in values.items()}


def defaults(autopilot: type[SimulatedAutopilot], **changes: float) -> dict[str, Parameter]:
    table = {parameter.name: parameter.default for parameter in autopilot.PARAMETERS}
    return parameters(**(table | changes))


COPTER, PX4 = ArduCopterSetup(), Px4Setup()


def copter(**changes: float) -> dict[str, Parameter]:
    return defaults(ArduCopter, **changes)


def px4(**changes: float) -> dict[str, Parameter]:
    return defaults(Px4, **changes)


@pytest.mark.parametrize(
    ("safeguard", "is_on", "text"),
    [
        (COPTER.link_loss(copter(), OURS), True, "return after 5 s (FS_GCS_ENABLE = 1)"),
        (COPTER.link_loss(copter(FS_GCS_ENABLE=5), OURS), True, "land after 5 s (FS_GCS_ENABLE = 5)"),
        (COPTER.link_loss(copter(FS_GCS_ENABLE=0), OURS), False, "none (FS_GCS_ENABLE = 0)"),
        (COPTER.link_loss(copter(FS_GCS_TIMEOUT=300), OURS), False, "return after 300 s"),
        (COPTER.link_loss(copter(), 99), False, "when ids 254 to 255 fall silent, not ours, 99"),
        (COPTER.link_loss(copter(MAV_GCS_SYSID=255, MAV_GCS_SYSID_HI=0), OURS), False, "when ids 255 fall silent"),
        (COPTER.link_loss(parameters(FS_GCS_ENABLE=1, SYSID_MYGCS=254), OURS), True, "return after 5 s"),
        (PX4.link_loss(px4(), OURS), True, "return after 10 s (NAV_DLL_ACT = 2)"),
        (PX4.link_loss(px4(NAV_DLL_ACT=0), OURS), False, "none (NAV_DLL_ACT = 0)"),
        (PX4.link_loss(px4(COM_DL_LOSS_T=300), OURS), False, "return after 300 s"),
        (PX4.link_loss(px4(NAV_DLL_ACT=5), OURS), False, "terminate (NAV_DLL_ACT = 5)"),
        (PX4.link_loss(px4(NAV_DLL_ACT=6), OURS), False, "disarm (NAV_DLL_ACT = 6)"),
        (PX4.link_loss(px4(COM_DLL_EXCEPT=2), OURS), False, "not in Hold, in which it flies (COM_DLL_EXCEPT = 2)"),
        (PX4.link_loss(px4(COM_DLL_EXCEPT=5), OURS), True, "return after 10 s"),
        (COPTER.low_battery(copter()), True, "return at BATT_LOW_MAH = 2000"),
        (COPTER.low_battery(copter(BATT_FS_LOW_ACT=0)), False, "none"),
        (COPTER.low_battery(copter(BATT_LOW_MAH=0)), False, "without a threshold"),
        (COPTER.low_battery(copter(BATT_FS_LOW_ACT=5)), False, "terminate (BATT_FS_LOW_ACT = 5)"),
        (COPTER.low_battery(parameters(BATT_MONITOR=0)), False, "no battery monitor (BATT_MONITOR = 0)"),
        (PX4.low_battery(px4()), True, "return when critical"),
        (PX4.low_battery(px4(COM_LOW_BAT_ACT=0)), False, "a warning only"),
        (COPTER.arming_checks(copter()), True, "all (ARMING_CHECK = 1)"),
        (COPTER.arming_checks(copter(ARMING_CHECK=0)), False, "all off (ARMING_CHECK = 0)"),
        (COPTER.arming_checks(copter(ARMING_CHECK=64)), False, "some off (ARMING_CHECK = 64)"),
        (COPTER.arming_checks(parameters(ARMING_SKIPCHK=0)), True, "all (ARMING_SKIPCHK = 0)"),
        (COPTER.arming_checks(parameters(ARMING_SKIPCHK=8)), False, "some off (ARMING_SKIPCHK = 8)"),
        (PX4.arming_checks(px4()), True, "on"),
        (COPTER.other_failsafes(copter()), True, "position lost: land"),
        (COPTER.other_failsafes(copter(FS_EKF_ACTION=2)), False, "does not land (FS_EKF_ACTION = 2)"),
        (COPTER.other_failsafes(copter(FS_EKF_THRESH=0)), False, "none (FS_EKF_THRESH = 0)"),
        (PX4.other_failsafes(px4()), True, "remote control lost: NAV_RCL_ACT = 2"),
        (PX4.other_failsafes(px4(NAV_RCL_ACT=6)), False, "remote control lost: disarm (NAV_RCL_ACT = 6)"),
        (COPTER.return_place(copter(), 0), True, "its launch point"),
        (COPTER.return_place(copter(), 2), False, "one of 2 rally points"),
        (PX4.return_place(px4(), 0), True, "its launch point (RTL_TYPE = 0)"),
        (PX4.return_place(px4(), 1), False, "a rally point"),
        (PX4.return_place(px4(RTL_TYPE=1), 0), False, "where a mission may end (RTL_TYPE = 1)"),
        (PX4.at_fence(px4(GF_ACTION=4)), False, "terminate (GF_ACTION = 4)"),
        (COPTER.at_fence(copter()), True, "return, or land (FENCE_ACTION = 1)"),
        (COPTER.at_fence(copter(FENCE_ENABLE=0)), False, "none (FENCE_ENABLE = 0)"),
        (COPTER.at_fence(copter(FENCE_TYPE=3)), False, "none (FENCE_TYPE = 3)"),
        (COPTER.at_fence(copter(FENCE_ACTION=0)), False, "report only"),
        (PX4.at_fence(px4()), True, "hold (GF_ACTION = 2)"),
        (PX4.at_fence(px4(GF_ACTION=1)), False, "a warning only"),
        (PX4.at_fence(px4(GF_ACTION=0)), False, "none (GF_ACTION = 0)"),
    ],
)
def test_what_a_vehicle_does_by_itself(safeguard, is_on: bool, text: str) -> None:
    assert safeguard.is_on is is_on
    assert text in safeguard.text
    assert bool(safeguard.remedy) is not is_on


def test_parameters_of_the_battery_have_to_be_read_where_there_is_a_monitor() -> None:
    assert COPTER.further(parameters(BATT_MONITOR=0)) == ()
    assert ("BATT_FS_LOW_ACT",) in COPTER.further(parameters(BATT_MONITOR=4))


def test_limits_and_the_way_home_are_in_metres() -> None:
    assert COPTER.return_height_m(copter(RTL_ALT=3000)) == 30.0
    assert COPTER.return_height_m(parameters(RTL_ALT_M=15.0)) == 15.0
    assert PX4.return_height_m(px4()) == 30.0
    assert COPTER.return_climb_m(copter(RTL_CLIMB_MIN=250)) == 2.5
    assert COPTER.return_climb_m(parameters(RTL_CLIMB_MIN_M=2.5)) == 2.5
    assert PX4.return_climb_m(px4()) == 0.0


@pytest.mark.parametrize(
    ("setup", "found", "expected"),
    [
        (COPTER, copter(), {"RTL_ALT": 3550.0, "RTL_CLIMB_MIN": 0.0}),
        (COPTER, parameters(RTL_ALT_M=15.0, RTL_CLIMB_MIN_M=1.0), {"RTL_ALT_M": 35.5, "RTL_CLIMB_MIN_M": 0.0}),
        (PX4, px4(), {"RTL_RETURN_ALT": 35.5}),
    ],
)
def test_a_return_height_is_written_as_it_is_read(setup, found, expected: dict[str, float]) -> None:
    assert setup.return_parameters(found, 35.5) == expected
    written = parameters(**expected)
    assert setup.return_height_m(written) == 35.5
    assert setup.return_climb_m(written) == 0.0
    assert (COPTER.ceiling_m(copter()), COPTER.radius_m(copter())) == (120.0, 500.0)
    assert (COPTER.ceiling_m(copter(FENCE_TYPE=4)), COPTER.radius_m(copter(FENCE_TYPE=4))) == (None, None)
    assert (PX4.ceiling_m(px4(GF_MAX_VER_DIST=0)), PX4.radius_m(px4(GF_MAX_HOR_DIST=0))) == (None, None)


@pytest.mark.parametrize("ceiling_m", [None, 45.5])
@pytest.mark.parametrize(
    ("setup", "found"),
    [
        (COPTER, copter(FENCE_ENABLE=0, FENCE_ACTION=0)),
        (COPTER, copter(FENCE_ACTION=4)),
        (PX4, px4(GF_ACTION=1)),
        (PX4, px4(GF_ACTION=4)),
        (PX4, px4(GF_ACTION=5)),
    ],
)
def test_our_fence_is_kept_and_nothing_else_limits_the_flight(setup, found, ceiling_m: float | None) -> None:
    written = found | parameters(**setup.fence_parameters(found, ceiling_m))
    assert setup.at_fence(written).is_on
    assert (setup.ceiling_m(written), setup.radius_m(written)) == (ceiling_m, None)
    if setup.at_fence(found).is_on:
        assert setup.at_fence(written).text == setup.at_fence(found).text, "the owner's choice"
