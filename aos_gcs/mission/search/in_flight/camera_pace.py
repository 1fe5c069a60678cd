"""Pace of each camera in flight, and the choice between interval capture and requests.

Neither choice is for good: what is slow may be the camera, its link, or this station for some seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aos_gcs.imaging.model import IntervalCapture
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.journal import Announcer
from aos_gcs.ports import Severity

WINDOW_S = 15.0
"""Least time of exposures over which the pace of a camera is judged, sweep after sweep, ..."""
_WINDOW_PERIODS = 5.0
"""... and the periods of its rate that have to fit into it."""
SLOW = 0.5
"""Share of the wanted rate below which a camera is slow."""
FASTER = 1.5
"""Pace of requested images over that of an interval below which these requests have gained nothing."""
RETRY_S = 60.0
"""Time after which what was given up is tried again; each further attempt in vain doubles it, ..."""
MOST_RETRY_S = 480.0
"""... up to this."""
UNANSWERED_S = 15.0
"""Time after which a camera that has not answered is asked to take images by itself again."""
COMMON_SHARE = 0.5
"""Share of the cameras, three at least, that are slow at the same time for another reason than themselves."""
_COMMON_LEAST = 3


@dataclass(slots=True)
class _Camera:
    """What is known of one camera."""

    last_at_s: float
    """Time of its latest image, or of what else its pace is reckoned from."""
    span_s: float = 0.0
    images: int = 0
    by_interval: bool = True
    """Whether these came by interval capture."""
    is_slow: bool = False
    """Whether it was slow when it was judged last."""
    requests_until_s: float = -math.inf
    """Time until which each image is requested; infinite: for the rest of the mission."""
    given_up_hz: float | None = None
    """Pace at which interval capture was given up, while requests have to prove that they gain something."""
    keeps_until_s: float = -math.inf
    """Time until which interval capture goes on, slow or not: requests have gained nothing."""
    wait_s: float = RETRY_S
    """Time after which to try again what is given up next."""

    def add(self, now_s: float, *, by_interval: bool) -> None:
        """Add an image to those that the camera is judged by, which have come in the same way."""
        if by_interval is not self.by_interval:
            self.by_interval, self.span_s, self.images = by_interval, 0.0, 0
        self.span_s += now_s - self.last_at_s
        self.last_at_s = now_s
        self.images += 1

    def seems_slow(self, slow_hz: float) -> bool:
        """Return whether it is slow at present, as far as is known."""
        return self.is_slow if self.span_s < 0.5 * WINDOW_S else self.images < slow_hz * self.span_s


class CameraPace:
    """Judges the pace of the cameras of one mission, and says once of each what is wrong with it.

    Single images are requested from a camera whose interval capture is too slow: many have a least time between two
    images of an interval. Where requests are no faster, and after :data:`RETRY_S` in any case, it takes images by
    itself again.

    Args:
        settings: wanted rate, and whether cameras may take images by themselves.
        journal: told of slow cameras, and of those that take images on request only.
    """

    def __init__(self, settings: ImagingSettings, journal: Announcer) -> None:
        self._rate_hz = settings.rate_hz
        self._slow_hz = SLOW * settings.rate_hz
        self._is_interval_wanted = settings.interval_capture is IntervalCapture.AUTO
        self._journal = journal
        self._cameras: dict[int, _Camera] = {}
        self._said: set[tuple[int, str]] = set()
        """What was said of which vehicle."""
        self._is_common_named = False

    def takes_interval(self, vehicle_id: int, now_s: float) -> bool:
        """Return whether to have a camera take images by itself."""
        return self._is_interval_wanted and now_s >= self._cameras[vehicle_id].requests_until_s

    def refuse_interval(self, vehicle_id: int, now_s: float, reason: str, *, may_pass: bool) -> None:
        """Request single images from a camera that does not take them by itself.

        Args:
            vehicle_id: vehicle of the camera.
            now_s: present time.
            reason: what it, or its driver, says.
            may_pass: whether to try again; else it is left alone for the rest of the mission.
        """
        camera = self._cameras[vehicle_id]
        camera.given_up_hz = None
        camera.requests_until_s = now_s + self._next_wait_s(camera) if may_pass else math.inf
        self._say(vehicle_id, "refused", f"each image of its camera is requested, without interval capture: {reason}")

    def put_off_interval(self, vehicle_id: int, now_s: float) -> None:
        """Request single images for a while from a camera that has not answered."""
        camera = self._cameras[vehicle_id]
        camera.given_up_hz, camera.requests_until_s = None, now_s + UNANSWERED_S

    def begin(self, vehicle_id: int, now_s: float) -> None:
        """Note that a camera begins to take images in flight."""
        camera = self._cameras.setdefault(vehicle_id, _Camera(now_s))
        camera.last_at_s = now_s

    def forgive(self, now_s: float) -> None:
        """Note that this station has stood still until now: no camera is to blame for that time."""
        for camera in self._cameras.values():
            camera.last_at_s = max(camera.last_at_s, now_s)

    def note_image(self, vehicle_id: int, now_s: float) -> None:
        """Note an image that has come; act where too few have."""
        camera = self._cameras[vehicle_id]
        camera.add(now_s, by_interval=self.takes_interval(vehicle_id, now_s))
        if camera.span_s < max(WINDOW_S, _WINDOW_PERIODS / self._rate_hz):
            return
        pace_hz = camera.images / camera.span_s
        camera.span_s, camera.images, camera.is_slow = 0.0, 0, pace_hz < self._slow_hz
        if camera.by_interval:
            self._judge_interval(vehicle_id, camera, pace_hz, now_s)
        elif camera.is_slow:
            self._judge_requests(vehicle_id, camera, pace_hz, now_s)

    def _judge_interval(self, vehicle_id: int, camera: _Camera, pace_hz: float, now_s: float) -> None:
        if not camera.is_slow:
            if now_s >= camera.requests_until_s + RETRY_S:
                camera.wait_s = RETRY_S
            return
        if now_s < camera.keeps_until_s:
            self._name_slow(vehicle_id, pace_hz)
            return
        camera.given_up_hz = pace_hz
        camera.requests_until_s = now_s + self._next_wait_s(camera)
        reason = f"{pace_hz:.1f} images per second instead of {self._rate_hz:g}"
        self._say(
            vehicle_id, "slow", f"each image of its camera is requested for a while, without interval capture: {reason}"
        )

    def _judge_requests(self, vehicle_id: int, camera: _Camera, pace_hz: float, now_s: float) -> None:
        if camera.given_up_hz is not None and pace_hz < FASTER * camera.given_up_hz:
            camera.keeps_until_s = camera.requests_until_s
            camera.requests_until_s = now_s
            self._say(vehicle_id, "again", "its camera takes images by itself again: requested ones come no faster")
        self._name_slow(vehicle_id, pace_hz)

    def _next_wait_s(self, camera: _Camera) -> float:
        wait_s = camera.wait_s
        camera.wait_s = min(2.0 * wait_s, MOST_RETRY_S)
        return wait_s

    def _name_slow(self, vehicle_id: int, pace_hz: float) -> None:
        """Name a camera that is slow both ways, or what is common to those that are."""
        pace = f"{pace_hz:.1f} images per second instead of {self._rate_hz:g}"
        slow = sum(camera.seems_slow(self._slow_hz) for camera in self._cameras.values())
        if slow < max(_COMMON_LEAST, COMMON_SHARE * len(self._cameras)):
            self._say(vehicle_id, "named", f"its camera delivers {pace}", Severity.WARNING)
        elif not self._is_common_named:
            self._is_common_named = True
            text = (
                f"{slow} of {len(self._cameras)} cameras deliver about {pace}: where they can do more, their link or "
                "this station is too slow; lower the frame rate, or use fewer vehicles"
            )
            self._journal.notice(Severity.WARNING, text)

    def _say(self, vehicle_id: int, what: str, text: str, severity: Severity = Severity.INFO) -> None:
        if (vehicle_id, what) not in self._said:
            self._said.add((vehicle_id, what))
            self._journal.notice(severity, text, vehicle_id)
