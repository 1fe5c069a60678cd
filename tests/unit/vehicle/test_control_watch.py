from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.control import Climb, ControlWatch
from aos_gcs.geometry.geodesy import GeodeticPosition

GUIDED, BRAKE = frozenset({"GUIDED"}), frozenset({"BRAKE"})
OURS = GUIDED | BRAKE | {"RTL", "LAND"}
HERE = GeodeticPosition(48.0, 14.0, 330.0)
THERE = GeodeticPosition(48.0001, 14.0, 330.0)
ELSEWHERE = GeodeticPosition(48.0, 14.0001, 330.0)


def heartbeat(status: int = mavlink.MAV_STATE_ACTIVE, *, armed: bool = True) -> mavlink.MAVLink_message:
    base_mode = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0
    return mavlink.MAVLink_heartbeat_message(2, 3, base_mode, 0, status, 3)


def watch(*modes: str, start_s: float = 0.0, control: ControlWatch | None = None) -> ControlWatch:
    """Take one heartbeat per second."""
    control = control or ControlWatch()
    for second, mode in enumerate(modes):
        control.take_heartbeat(mode, heartbeat(), OURS, start_s + second)
    return control


def flying_to_here() -> ControlWatch:
    control = watch("GUIDED")
    control.begin(GUIDED, HERE)
    control.confirm(HERE, 1.0, has_target=True)
    return control


def test_older_modes_are_explained_until_a_newer_command_has_taken_effect() -> None:
    control = watch("GUIDED")
    control.begin(GUIDED, HERE)
    control.begin(BRAKE, None)
    watch(*["GUIDED"] * 20, "BRAKE", "GUIDED", "BRAKE", start_s=1.0, control=control)
    assert control.takeovers == 0
    watch("GUIDED", start_s=30.0, control=control)
    assert control.reason == "its mode changed to GUIDED"


def test_a_mode_that_we_never_command_is_a_take_over_before_any_command() -> None:
    assert watch("GUIDED", "RTL").reason == ""
    assert watch("LOITER").reason == "its mode changed to LOITER"


def test_a_take_over_stays_one_when_the_pilot_returns_to_our_mode() -> None:
    control = watch("GUIDED")
    control.begin(GUIDED, HERE)
    watch("GUIDED", "STABILIZE", "GUIDED", "GUIDED", start_s=1.0, control=control)
    assert control.reason
    control.reclaim()
    watch("GUIDED", start_s=6.0, control=control)
    assert control.reason == ""


@pytest.mark.parametrize(
    ("top_m", "reported_m", "reason"),
    [
        (43.3, 42.1, ""),  # PX4 in software was there when its take-off ended
        (43.3, 40.4, ""),
        (43.3, 40.2, "its mode changed to BRAKE"),
        (5.0, 4.0, ""),
        (5.0, 3.0, "its mode changed to BRAKE"),
    ],
)
def test_a_mode_that_ends_a_take_off_is_a_take_over_below_its_top(top_m: float, reported_m: float, reason: str) -> None:
    control = watch("BRAKE")
    control.begin(GUIDED, None, Climb(top_m, BRAKE))
    watch(*["GUIDED"] * 6, start_s=1.0, control=control)
    control.take_height(reported_m)
    watch("BRAKE", start_s=7.0, control=control)
    assert control.reason == reason


def test_an_older_mode_after_the_vehicle_has_accepted_a_command_is_a_take_over() -> None:
    """A pilot may stop a take-off before any heartbeat shows it."""
    control = watch("BRAKE")
    control.begin(GUIDED, None)
    watch(*["BRAKE"] * 10, start_s=1.0, control=control)
    control.take_answer(11.0, is_accepted=True)
    watch("BRAKE", "BRAKE", "BRAKE", start_s=11.5, control=control)
    assert control.reason == ""
    watch("BRAKE", start_s=14.5, control=control)
    assert control.reason == "its mode changed to BRAKE"


def test_a_refusal_after_an_acceptance_leaves_the_vehicle_in_its_older_mode() -> None:
    control = watch("BRAKE")
    control.begin(GUIDED, None)
    control.take_answer(1.0, is_accepted=True)
    control.take_answer(1.1, is_accepted=False)
    watch(*["BRAKE"] * 10, start_s=1.0, control=control)
    assert control.reason == ""


def test_a_return_by_the_autopilot_itself_has_no_pilot_and_one_that_a_pilot_began_has() -> None:
    control = watch("GUIDED")
    control.begin(GUIDED, HERE)
    watch("GUIDED", control=control, start_s=1.0)
    control.take_heartbeat("RTL", heartbeat(), OURS, 9.0, comes_down=True)
    assert (control.takeovers, control.has_pilot) == (1, False)
    control.take_heartbeat("LOITER", heartbeat(), OURS, 10.0)
    control.take_heartbeat("LAND", heartbeat(), OURS, 11.0, comes_down=True)
    assert (control.takeovers, control.has_pilot) == (3, True)
    control.begin(frozenset({"LAND"}), None)
    assert not control.has_pilot


@pytest.mark.parametrize("way_down", ["RTL", "LAND"])
def test_only_a_pilot_ends_a_way_down_that_a_restarted_station_finds(way_down: str) -> None:
    control = ControlWatch()
    control.take_heartbeat(way_down, heartbeat(), OURS, 0.0, comes_down=True)
    control.take_heartbeat("RTL", heartbeat(), OURS, 1.0, comes_down=True)
    assert control.takeovers == 0
    control.take_heartbeat("BRAKE", heartbeat(), OURS, 2.0)
    assert (control.reason, control.has_pilot) == ("its mode changed to BRAKE", True)


def test_a_hold_that_a_restarted_station_commands_ends_a_way_down_without_a_pilot() -> None:
    control = ControlWatch()
    control.take_heartbeat("RTL", heartbeat(), OURS, 0.0, comes_down=True)
    control.begin(BRAKE, None)
    control.take_heartbeat("BRAKE", heartbeat(), OURS, 1.0)
    assert control.takeovers == 0


def test_a_take_over_ends_with_the_motors() -> None:
    control = watch("LOITER")
    control.take_heartbeat("LOITER", heartbeat(armed=False), OURS, 1.0)
    assert control.reason == ""


def test_a_pilot_who_has_landed_is_known_until_the_motors_run_again() -> None:
    control = watch("GUIDED")
    control.begin(GUIDED, HERE)
    watch("LOITER", "LAND", start_s=4.0, control=control)
    for second in (6.0, 7.0):
        control.take_heartbeat("LAND", heartbeat(armed=False), OURS, second)
        assert (control.reason, control.has_pilot) == ("", True)
    watch("GUIDED", start_s=8.0, control=control)
    assert not control.has_pilot


def test_two_reports_of_another_target_are_a_take_over() -> None:
    control = flying_to_here()
    for target in (HERE, THERE, HERE, THERE):
        control.take_target(target, 2.0)
    assert control.takeovers == 0
    control.take_target(THERE, 2.5)
    assert control.reason == "it flies to a target of another station or pilot"


def test_a_target_near_the_former_one_is_still_ours() -> None:
    """The vehicle may still report at the confirmation its former target, 1.7 m from the new one."""
    control = watch("GUIDED")
    control.begin(GUIDED, HERE)
    control.confirm(GeodeticPosition(HERE.latitude_deg + 1.5e-5, 14.0, 330.0), 1.0, has_target=True)
    for second in range(5):
        control.take_target(HERE, 2.0 + second)
    assert control.reason == ""
    for second in range(2):
        control.take_target(THERE, 8.0 + second)
    assert control.reason == "it flies to a target of another station or pilot"


def test_late_reports_of_former_targets_are_no_take_over() -> None:
    control = flying_to_here()
    control.take_target(HERE, 1.0)
    for target in (ELSEWHERE, THERE):  # the first one is never reported in time
        control.begin(GUIDED, target)
        control.confirm(HERE, 2.0, has_target=True)
    for late_s, target in enumerate((HERE, HERE, ELSEWHERE, ELSEWHERE, THERE, THERE)):
        control.take_target(target, 4.0 + late_s)
        assert control.reason == ""
    for late_s in range(2):
        control.take_target(HERE, 14.0 + late_s)
    assert control.reason, "a former target that is reported this late is flown to again"


def test_a_velocity_of_another_station_is_a_take_over() -> None:
    control = flying_to_here()
    control.take_target(None, 2.0)
    control.take_target(None, 3.0)
    assert control.takeovers == 1


def beat(control: ControlWatch, seconds: range, mode: str = "GUIDED", *, reports_targets: bool = True) -> None:
    for second in seconds:
        control.take_heartbeat(mode, heartbeat(), OURS, float(second), reports_targets=reports_targets)


def test_a_vehicle_that_has_no_target_any_more_is_flown_by_attitudes_of_another_station() -> None:
    control = flying_to_here()
    control.hear_target()
    beat(control, range(10, 16))
    assert control.misses_target
    beat(control, range(16, 17))
    assert not control.misses_target, "it is asked once"
    control.begin(GUIDED, THERE)  # a waypoint of ours does not begin the count anew
    beat(control, range(17, 19))
    assert control.takeovers == 0
    beat(control, range(19, 20))
    assert control.reason == "it reports no target any more, as when another station sets its attitude"
    assert control.has_pilot
    beat(control, range(20, 50))
    assert control.takeovers == 1
    control.reclaim()
    beat(control, range(50, 80))
    assert control.reason == ""


def test_heartbeats_that_come_at_once_are_no_time_without_a_target() -> None:
    control = flying_to_here()
    control.hear_target()
    for _ in range(40):
        control.take_heartbeat("GUIDED", heartbeat(), OURS, 10.0, reports_targets=True)
    assert control.takeovers == 0


def test_a_target_that_is_reported_now_and_then_never_was_or_not_in_this_mode_is_no_take_over() -> None:
    control = flying_to_here()
    beat(control, range(10, 40))
    assert control.takeovers == 0, "its version may report none"
    for start in range(40, 90, 10):
        control.hear_target()
        beat(control, range(start, start + 9))
    control.begin(BRAKE, None)
    beat(control, range(90, 120), "BRAKE", reports_targets=False)
    assert control.takeovers == 0


def test_no_target_is_judged_while_a_command_is_on_its_way_or_has_none() -> None:
    control = flying_to_here()
    control.begin(GUIDED, THERE)
    for target in (THERE, THERE, None, None):
        control.take_target(target, 2.0)
    control.confirm(None, 3.0, has_target=False)
    for target in (HERE, THERE, None, None):
        control.take_target(target, 9.0)
    assert control.takeovers == 0


@pytest.mark.parametrize(
    ("status", "failsafe"),
    [
        (mavlink.MAV_STATE_ACTIVE, ""),
        (mavlink.MAV_STATE_CRITICAL, "critical"),
        (mavlink.MAV_STATE_EMERGENCY, "emergency"),
        (mavlink.MAV_STATE_FLIGHT_TERMINATION, "flight termination"),
    ],
)
def test_the_status_of_the_heartbeat_shows_a_failsafe_while_motors_run(status: int, failsafe: str) -> None:
    control = ControlWatch()
    control.take_heartbeat("GUIDED", heartbeat(status, armed=False), OURS, 0.0)
    assert control.failsafe == ""
    control.take_heartbeat("GUIDED", heartbeat(status), OURS, 1.0)
    assert control.failsafe == failsafe


def test_a_text_reports_a_failsafe_until_the_next_heartbeat() -> None:
    control = watch("GUIDED")
    control.take_text("Failsafe activated, entering Hold for 5 seconds")
    assert control.failsafe == "reported"
    watch("GUIDED", start_s=1.0, control=control)
    assert control.failsafe == ""


def answer(command: int, result: int = mavlink.MAV_RESULT_ACCEPTED) -> mavlink.MAVLink_command_ack_message:
    return mavlink.MAVLink_command_ack_message(command, result, target_system=255, target_component=190)


def test_who_accepts_a_command_of_another_station_to_fly_is_taken_over_at_once() -> None:
    """PX4 stopped for another station, and our next waypoint was due before it had reported its target twice."""
    control = flying_to_here()
    control.hear_answer_to_another(answer(mavlink.MAV_CMD_DO_REPOSITION))
    assert (control.reason, control.has_pilot) == ("it follows a command of station 255", True)
    control.reclaim()
    assert not control.reason


@pytest.mark.parametrize(
    ("command", "result"),
    [
        (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAV_RESULT_ACCEPTED),
        (mavlink.MAV_CMD_IMAGE_START_CAPTURE, mavlink.MAV_RESULT_ACCEPTED),
        (mavlink.MAV_CMD_DO_REPOSITION, mavlink.MAV_RESULT_DENIED),
    ],
)
def test_other_answers_to_another_station_are_no_take_over(command: int, result: int) -> None:
    control = flying_to_here()
    control.hear_answer_to_another(answer(command, result))
    assert not control.reason


def test_on_the_ground_a_command_of_another_station_is_no_take_over() -> None:
    control = ControlWatch()
    control.take_heartbeat("GUIDED", heartbeat(armed=False), OURS, 0.0)
    control.hear_answer_to_another(answer(mavlink.MAV_CMD_DO_SET_MODE))
    assert not control.reason
