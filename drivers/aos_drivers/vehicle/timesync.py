"""Round trip, clock offset and drift of one vehicle from MAVLink's TIMESYNC.

Every answer bounds the offset: the vehicle read its clock somewhere between our sending and receiving, so the middle
of both errs by at most half of the round trip, however asymmetric the delays are. Queues only ever add to a delay;
hence the answers with the shortest round trips are used alone (the minimum filter of NTP, RFC 5905, section 10).

A drift is a rate that lasts. A computer that stands still for some tenths of a second looks like one over all answers,
but not in the rates between neighbouring ones; a noisy link the other way round. The lower one of both is reported.

Two answers in a row whose bounds exclude what the clock has read until then show that it has stood still or was set.
The offset is that of the answers since then; the drift, which outlasts a stall, is still found in all.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import ardupilotmega as mavlink

PERIOD_S = 2.0
"""Pause between two requests to one vehicle."""
_SAMPLES = 120
_OPEN_REQUESTS = 64
"""Requests that may be answered yet: those of two minutes, as a queue may deliver answers that late."""
_BEST_SHARE = 0.25
_DRIFT_SAMPLES = 10
_DRIFT_SPAN_S = 60.0
_BLOCK_S = 10.0
"""Time of which the answer with the shortest round trip stands for all, where rates are compared."""
_JUMP_S = 1.0
"""Change of the offset that makes it another clock, of which nothing is known."""
_FASTEST_DRIFT = 0.01
"""Seconds per second that a clock may gain; one that seems to gain more was set, or has stood still."""
_NEIGHBOURS = 5
"""Latest answers that bound the next ones."""
_SLACK_S = 0.002
"""Error of an answer's bounds: the clocks' resolution."""


@dataclass(frozen=True, slots=True)
class _Sample:
    at_s: float
    offset_s: float
    round_trip_s: float
    run: int
    """Counts the times that the clock has stood still or was set before."""


class ClockEstimator:
    """The clock of one vehicle against ours, over the last 120 answers (four minutes).

    The vehicle's clock is whatever its TIMESYNC says, mostly the time since boot.
    """

    def __init__(self) -> None:
        self._open: deque[int] = deque(maxlen=_OPEN_REQUESTS)
        self._samples: deque[_Sample] = deque(maxlen=_SAMPLES)
        self._run = 0
        self._contradiction: _Sample | None = None
        """The latest answer, if it contradicts those before it: with the next one, the beginning of another run."""
        self._slope = 0.0
        """Seconds per second that the answers' offsets change, to the best of our knowledge."""
        self._error_s = np.inf
        """Largest error of the offset and slope."""
        self._due_s = -np.inf
        self.last_round_trip_s: float | None = None
        self.round_trip_s: float | None = None
        """The median of the latest answers."""
        self.offset_s: float | None = None
        """The vehicle's clock minus ours, at the latest answer."""
        self.drift: float | None = None
        """Seconds that the vehicle's clock gains on ours per second; None before a minute has been seen."""

    def poll(self, now_s: float) -> int | None:
        """Return the time in nanoseconds for a request (``ts1``) when one is due."""
        if now_s < self._due_s:
            return None
        self._due_s = now_s + PERIOD_S
        sent_ns = round(now_s * 1e9) + 1  # 0 would mark a request that was never made
        self._open.append(sent_ns)
        return sent_ns

    def on_message(self, message: mavlink.MAVLink_timesync_message, now_s: float) -> None:
        """Take an answer; requests of the vehicle and answers that we did not ask for are ignored."""
        if message.tc1 == 0 or message.ts1 not in self._open:
            return
        while self._open and self._open[0] <= message.ts1:
            self._open.popleft()  # requests before it have been lost, or their answers have
        sent_s = message.ts1 / 1e9
        self.last_round_trip_s = max(0.0, now_s - sent_s)
        round_trip_s = self.last_round_trip_s
        sample = _Sample(now_s, message.tc1 / 1e9 - (sent_s + now_s) / 2, round_trip_s, self._run)
        if self.offset_s is not None and abs(sample.offset_s - self.offset_s) > _JUMP_S + round_trip_s / 2:
            self._samples.clear()
            self._contradiction = None
        if self._takes(sample):
            self._estimate()

    def _takes(self, sample: _Sample) -> bool:
        """Take an answer, unless it contradicts those before: two such answers in a row begin another run."""
        former, by_s = self._contradiction, self._contradicts_by_s(sample)
        self._contradiction = None
        if by_s == 0.0:
            self._samples.append(sample)
            return True
        if former is None or self._contradicts_by_s(former) * by_s < 0.0:
            self._contradiction = sample
            return False
        self._run += 1
        self._samples.extend(replace(one, run=self._run) for one in (former, sample))
        return True

    def _contradicts_by_s(self, sample: _Sample) -> float:
        """Return by how much an answer differs from what those before it allow; 0 if it does not."""
        bounds = []
        for known in list(self._samples)[-_NEIGHBOURS:]:
            if known.run == self._run:
                error_s = (known.round_trip_s + sample.round_trip_s) / 2 + _FASTEST_DRIFT * (sample.at_s - known.at_s)
                bounds.append((known.offset_s, error_s))
        if self.offset_s is not None and self._samples:
            expected_s = self.offset_s + self._slope * (sample.at_s - self._samples[-1].at_s)
            bounds.append((expected_s, sample.round_trip_s / 2 + self._error_s))
        excess_s = [sample.offset_s - middle_s for middle_s, error_s in bounds if _is_beyond(sample, middle_s, error_s)]
        return max(excess_s, key=abs, default=0.0)

    def longest_delay_s(self, now_s: float) -> float:
        """Return how long a message of the vehicle can have been on its way: as long as the answer to a request."""
        waiting_s = now_s - self._open[0] / 1e9 if self._open else 0.0
        return max(self.last_round_trip_s or 0.0, waiting_s)

    def _estimate(self) -> None:
        at_s, offsets_s, round_trips_s, runs = np.array(
            [(sample.at_s, sample.offset_s, sample.round_trip_s, sample.run) for sample in self._samples]
        ).T
        self.round_trip_s = float(np.median(round_trips_s[-10:]))
        is_best = round_trips_s <= np.quantile(round_trips_s, _BEST_SHARE)
        is_present = runs == self._run
        is_long = np.ptp(at_s[is_best]) >= _DRIFT_SPAN_S and np.count_nonzero(is_best) >= _DRIFT_SAMPLES
        if is_long:
            self._slope = _common_slope(at_s[is_best], offsets_s[is_best], runs[is_best])
            self.drift = _lower(self._slope, _lasting_rate(at_s, offsets_s, round_trips_s))
            used = is_present & (round_trips_s <= np.quantile(round_trips_s[is_present], _BEST_SHARE))
            self.offset_s = float(np.mean(offsets_s[used] - self._slope * (at_s[used] - at_s[-1])))
            self._error_s = float(round_trips_s[is_best | used].max())
        else:
            best = np.argmin(np.where(is_present, round_trips_s, np.inf))
            self.drift, self.offset_s = None, float(offsets_s[best])
            self._slope, self._error_s = 0.0, np.inf


def _is_beyond(sample: _Sample, middle_s: float, error_s: float) -> bool:
    return abs(sample.offset_s - middle_s) > error_s + _SLACK_S


def _common_slope(at_s: NDArray[np.float64], offsets_s: NDArray[np.float64], runs: NDArray[np.float64]) -> float:
    """Return the slope of the parallel lines that fit the answers of all runs best."""
    times_s, values_s = at_s.copy(), offsets_s.copy()
    for run in np.unique(runs):
        members = runs == run
        times_s[members] -= at_s[members].mean()
        values_s[members] -= offsets_s[members].mean()
    span = float(times_s @ times_s)
    return float(times_s @ values_s) / span if span > 0.0 else 0.0


def _lasting_rate(
    at_s: NDArray[np.float64], offsets_s: NDArray[np.float64], round_trips_s: NDArray[np.float64]
) -> float:
    """Return the rate that three of four pairs of successive blocks show, by the best answer of each; 0 if they differ.

    Pairs before and after a stall, or with a late answer, are among the fourth.
    """
    blocks, best = np.floor((at_s - at_s[0]) / _BLOCK_S), []
    for block in np.unique(blocks):
        (members,) = np.nonzero(blocks == block)
        best.append(members[np.argmin(round_trips_s[members])])
    low, high = np.quantile(np.diff(offsets_s[best]) / np.diff(at_s[best]), (0.25, 0.75))
    return _lower(float(low), float(high))


def _lower(one: float, other: float) -> float:
    """Return the one of two rates that is nearer to 0; 0 where they disagree about the direction."""
    return min(one, other, key=abs) if one * other > 0.0 else 0.0
