"""Tests that one worker runs one after another, and units that run beside each other."""

import pytest

from tests import schedule

DEMO = "tests/integration/test_demo_faults.py"
THREADED = "tests/contract/test_drivers.py [mavsdk]"
FLIGHT_WITH_PAGE = "tests/browser/test_browser_failures.py"
COMPUTED = "tests/integration/test_mission_flow.py"


@pytest.mark.parametrize(
    ("nodeid", "unit"),
    [
        ("tests/browser/test_browser_plan.py::test_a[x]", schedule.BROWSER),
        ("tests/browser/test_browser_failures.py::test_a", FLIGHT_WITH_PAGE),
        ("tests/integration/test_demo_faults.py::test_a", DEMO),
        ("tests/contract/test_drivers.py::test_a[mavsdk-px4]", THREADED),
        ("tests/contract/test_drivers.py::test_a[Goto-mavsdk]", THREADED),
        ("tests/contract/test_drivers.py::test_a[mavlink-px4]", "tests/contract/test_drivers.py"),
        ("tests/contract/test_drivers.py::test_mavsdk_is_named", "tests/contract/test_drivers.py"),
        ("tests/unit/mavsdk/test_wire.py::test_a[mavsdk]", "tests/unit/mavsdk/test_wire.py"),
    ],
)
def test_a_unit_is_a_module_but_for_the_browser_and_for_cases_with_threads(nodeid: str, unit: str) -> None:
    assert schedule.unit_of(nodeid) == unit


@pytest.mark.parametrize(
    ("units", "others", "chosen"),
    [
        ([schedule.BROWSER, DEMO, COMPUTED], [], schedule.BROWSER),
        ([FLIGHT_WITH_PAGE, DEMO, COMPUTED], [schedule.BROWSER], FLIGHT_WITH_PAGE),
        ([DEMO, THREADED, COMPUTED], [schedule.BROWSER], DEMO),
        ([THREADED, COMPUTED], [schedule.BROWSER, DEMO], COMPUTED),
        ([COMPUTED, THREADED], [schedule.BROWSER], THREADED),
        ([COMPUTED], [], COMPUTED),
        ([THREADED], [DEMO], THREADED),
    ],
)
def test_one_worker_waits_while_the_others_compute(units: list[str], others: list[str], chosen: str) -> None:
    assert schedule.next_unit(units, others) == chosen


def test_workers_that_only_compute_give_way_to_those_that_others_wait_for() -> None:
    assert [schedule.niceness(worker) > 0 for worker in ("gw0", "gw1", "gw2", "gw11")] == [False, False, True, True]


def test_all_beginnings_of_units_name_tests(request: pytest.FixtureRequest) -> None:
    root = request.config.rootpath
    for beginning in schedule.FIRST:
        assert list(root.glob(beginning.partition(" ")[0] + "*")), beginning
