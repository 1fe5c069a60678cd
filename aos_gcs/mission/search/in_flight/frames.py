"""Whether frames come in flight: where none did, the search stops for each until those at rest come as they would."""

from __future__ import annotations

from collections.abc import Mapping

from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.search.frames.sampling import Sample
from aos_gcs.mission.search.in_flight.exposing import MAX_MOTION_M, blind_s
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Capture, Severity

FIRST_STEPS = 3
"""Steps in a row whose frames have to come, as they would have to in flight, before the search flies on again."""
MOST_STEPS = 48
"""Greatest number of such steps: each attempt without frames doubles it, and costs some seconds and a way back."""
PROVEN_ROUNDS = 10
"""Rounds of frames in flight after which an earlier attempt without them no longer counts."""


class FramesInFlight:
    """Decides whether the search may sweep.

    Args:
        settings: settings of the mission.
        journal: told when the search changes to stops and back.
    """

    def __init__(self, settings: MissionSettings, journal: Announcer) -> None:
        self._settings = settings
        self._journal = journal
        self._is_wanted = settings.search.mode is SearchMode.CONTINUOUS
        self._is_suspended = False
        self._needed = FIRST_STEPS
        """Good steps at rest, in a row, that end the suspension."""
        self._good_steps, self._rounds = 0, 0

    @property
    def is_sweep_allowed(self) -> bool:
        """Whether the search may fly along its legs without stops."""
        return self._is_wanted and not self._is_suspended

    def note_round(self) -> None:
        """Note a round of frames in flight."""
        self._rounds += 1

    def note_silence(self, silence: str) -> None:
        """Note that no frame came in flight for too long, as these words say: the search goes on with stops."""
        self._journal.notice(Severity.WARNING, f"{silence}: the search goes on with stops")
        has_failed_again = self._good_steps > 0 and self._rounds < PROVEN_ROUNDS
        self._needed = min(MOST_STEPS, 2 * self._needed) if has_failed_again else FIRST_STEPS
        self._is_suspended, self._good_steps, self._rounds = True, 0, 0

    def look_at_rest(self, taken: Sample, took_s: Mapping[int, float]) -> None:
        """Look at a step's frames, taken at rest: would they have come in flight?

        Args:
            taken: the frames of the step.
            took_s: time from the step's beginning until each vehicle's image was there, by id.
        """
        if not self._is_suspended:
            return
        fit = [one for one in taken.captures if self._is_fit(one) and took_s[one.vehicle_id] <= self._blind_s]
        # In flight the line may miss the frames of some vehicles, not those of most.
        is_enough = 2 * len(fit) >= len(taken.captures) + len(taken.missing) and bool(fit)
        self._good_steps = self._good_steps + 1 if is_enough else 0
        if self._good_steps == self._needed:
            self._is_suspended = False
            self._journal.notice(Severity.INFO, "Frames received again. The search continues without stops")

    def _is_fit(self, capture: Capture) -> bool:
        sigma_s = self._settings.uncertainty.clock_s if capture.time_sigma_s is None else capture.time_sigma_s
        return sigma_s * self._settings.flight.leg_speed_mps <= MAX_MOTION_M

    @property
    def _blind_s(self) -> float:
        return blind_s(self._settings.imaging.rate_hz)
