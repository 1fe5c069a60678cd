"""Choice between a camera that takes images by itself and one that is asked for each, and causes named for too few."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from aos_gcs.imaging.model import IntervalCapture
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.search.in_flight.camera_pace import MOST_RETRY_S, RETRY_S, UNANSWERED_S, WINDOW_S, CameraPace
from aos_gcs.ports import Severity

RATE_HZ = 2.0
LEFT_S = WINDOW_S + 4.0
"""Time after which a slow camera has been judged."""


@dataclass
class Heard:
    """Journal that keeps its notices, each with its vehicle."""

    notices: list[tuple[Severity, str, int | None]] = field(default_factory=list)

    def elapsed_s(self) -> float:
        return 0.0

    def notice(
        self,
        severity: Severity,
        text: str,
        vehicle_id: int | None = None,
        *,
        track_id: int | None = None,  # noqa: ARG002
    ) -> None:
        self.notices.append((severity, text, vehicle_id))

    def texts(self, part: str) -> list[int | None]:
        return [vehicle_id for _, text, vehicle_id in self.notices if part in text]


class Cameras:
    """Cameras that deliver at a pace of their own, one for each way."""

    def __init__(self, n: int = 1, interval_capture: IntervalCapture = IntervalCapture.AUTO) -> None:
        self.heard = Heard()
        self.pace = CameraPace(ImagingSettings(rate_hz=RATE_HZ, interval_capture=interval_capture), self.heard)
        self.now_s = 100.0
        self.ids = range(1, n + 1)
        self.interval_hz = dict.fromkeys(self.ids, RATE_HZ)
        self.requested_hz = dict.fromkeys(self.ids, RATE_HZ)
        self._due_s = dict.fromkeys(self.ids, self.now_s)
        for number in self.ids:
            self.pace.begin(number, self.now_s)

    def takes_interval(self, number: int = 1) -> bool:
        return self.pace.takes_interval(number, self.now_s)

    def fly(self, duration_s: float) -> None:
        """Let the cameras take images for a while."""
        end_s = self.now_s + duration_s
        while self.now_s < end_s:
            self.now_s += 0.25
            for number in self.ids:
                if self.now_s >= self._due_s[number]:
                    paces_hz = self.interval_hz if self.takes_interval(number) else self.requested_hz
                    self._due_s[number] = self.now_s + 1.0 / paces_hz[number]
                    self.pace.note_image(number, self.now_s)


def test_a_camera_that_keeps_the_rate_takes_images_by_itself_and_nobody_speaks_of_it() -> None:
    cameras = Cameras()
    cameras.fly(300.0)
    assert cameras.takes_interval()
    assert not cameras.heard.notices


def test_where_it_is_switched_off_no_camera_takes_images_by_itself() -> None:
    cameras = Cameras(interval_capture=IntervalCapture.OFF)
    cameras.fly(300.0)
    assert not cameras.takes_interval()
    assert not cameras.heard.notices


def test_some_slow_seconds_change_nothing() -> None:
    cameras = Cameras()
    for _ in range(10):
        cameras.fly(2.0 * WINDOW_S)
        cameras.interval_hz[1] = 0.3
        cameras.fly(0.3 * WINDOW_S)
        cameras.interval_hz[1] = RATE_HZ
    assert cameras.takes_interval()
    assert not cameras.heard.notices


def test_a_slow_interval_is_given_up_and_tried_again_until_it_is_fast() -> None:
    cameras = Cameras()
    cameras.interval_hz[1] = 0.3
    cameras.fly(LEFT_S)
    assert not cameras.takes_interval()
    cameras.interval_hz[1] = RATE_HZ
    cameras.fly(RETRY_S)
    assert cameras.takes_interval()
    cameras.fly(300.0)
    assert cameras.takes_interval()
    ((severity, text, vehicle_id),) = cameras.heard.notices
    assert (severity, vehicle_id) == (Severity.INFO, 1)
    assert text.endswith("for a while, without interval capture: 0.3 images per second instead of 2")


def test_a_least_interval_is_tried_more_and_more_seldom_and_named_once() -> None:
    cameras = Cameras()
    cameras.interval_hz[1] = 0.3
    by_interval_s = 0.0
    for _ in range(3600):
        by_interval_s += cameras.takes_interval()
        cameras.fly(1.0)
    assert by_interval_s < 0.07 * 3600.0
    assert len(cameras.heard.notices) == 1
    cameras.interval_hz[1] = RATE_HZ
    cameras.fly(MOST_RETRY_S)
    assert cameras.takes_interval()


def test_what_lasts_is_trusted_as_at_first() -> None:
    cameras = Cameras()
    for _ in range(4):
        cameras.interval_hz[1] = 0.3
        cameras.fly(2.0 * WINDOW_S)
        assert not cameras.takes_interval()
        cameras.interval_hz[1] = RATE_HZ
        cameras.fly(RETRY_S)
        assert cameras.takes_interval()
        cameras.fly(2.0 * RETRY_S)


def test_requests_that_come_no_faster_are_given_up_for_the_interval() -> None:
    cameras = Cameras()
    cameras.interval_hz[1] = cameras.requested_hz[1] = 0.6
    cameras.fly(2.0 * LEFT_S)
    assert cameras.takes_interval()
    cameras.fly(RETRY_S - 2.0 * LEFT_S)
    assert cameras.takes_interval()
    assert cameras.heard.texts("its camera delivers 0.6 images per second instead of 2") == [1]
    assert len(cameras.heard.texts("by itself again: requested ones come no faster")) == 1


def test_where_most_are_slow_one_notice_says_so_and_blames_no_camera() -> None:
    cameras = Cameras(10)
    for number in range(1, 9):
        cameras.interval_hz[number] = cameras.requested_hz[number] = 0.6
    cameras.fly(4.0 * LEFT_S)
    assert [cameras.takes_interval(number) for number in cameras.ids] == [True] * 10
    warnings = [
        (text, vehicle_id) for severity, text, vehicle_id in cameras.heard.notices if severity >= Severity.WARNING
    ]
    assert len(warnings) == 1
    assert warnings[0][0].startswith("8 of 10 cameras deliver about 0.6 images per second instead of 2")
    assert warnings[0][1] is None


def test_time_in_which_the_station_stood_still_is_no_cameras_fault() -> None:
    cameras = Cameras(2)
    for _ in range(20):
        cameras.fly(3.0)
        cameras.now_s += 4.0
        cameras.pace.forgive(cameras.now_s)
    assert cameras.takes_interval(1)
    assert not cameras.heard.notices


def test_short_sweeps_are_judged_together() -> None:
    cameras = Cameras()
    cameras.interval_hz[1] = 0.4
    for _ in range(4):
        cameras.fly(0.6 * WINDOW_S)
        cameras.now_s += 60.0
        cameras.pace.begin(1, cameras.now_s)
    assert cameras.heard.texts("without interval capture") == [1]


@pytest.mark.parametrize("may_pass", [True, False])
def test_a_refusal_is_for_good_unless_it_may_pass(may_pass: bool) -> None:
    cameras = Cameras()
    for _ in range(2):
        cameras.pace.refuse_interval(1, cameras.now_s, "it takes no image", may_pass=may_pass)
        cameras.fly(0.9 * RETRY_S)
        assert not cameras.takes_interval()
        cameras.fly(0.2 * RETRY_S)
        if not may_pass:
            break
        cameras.fly(RETRY_S)
        assert cameras.takes_interval()
    cameras.fly(2.0 * MOST_RETRY_S)
    assert cameras.takes_interval() is may_pass
    assert len(cameras.heard.notices) == 1


def test_a_refusal_for_good_is_not_undone_by_slow_requests() -> None:
    cameras = Cameras()
    cameras.interval_hz[1] = cameras.requested_hz[1] = 0.3
    cameras.fly(LEFT_S)
    cameras.pace.refuse_interval(1, cameras.now_s, "another station has stopped it", may_pass=False)
    cameras.fly(MOST_RETRY_S)
    assert not cameras.takes_interval()


def test_a_camera_that_has_not_answered_is_asked_again_soon() -> None:
    cameras = Cameras()
    cameras.pace.put_off_interval(1, cameras.now_s)
    assert not cameras.takes_interval()
    cameras.fly(UNANSWERED_S)
    assert cameras.takes_interval()
    assert not cameras.heard.notices
