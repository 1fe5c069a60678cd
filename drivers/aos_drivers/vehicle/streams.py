"""Requests for the messages that we need, at rates that a swarm's radio can carry."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_ACK_TIMEOUT_S = 1.0
_ATTEMPTS = 4
_WATCH_S = 5.0
_LOWEST_SHARE = 0.5
_WATCHED = mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT
_STREAM_RETRIES = 3
"""Number of further requests for a stream that does not arrive; the vehicle may not have it."""


class StreamKeeper:
    """Requests one stream after the other (SET_MESSAGE_INTERVAL) and starts over when positions become rare.

    Another ground station or a reboot resets our rates; the rate of positions shows both. One request is open at a
    time, because an acknowledgement does not name its message. Where packets are lost, that of a repeated request may
    be taken for the next one's: a stream that then does not arrive is requested again.
    """

    __slots__ = (
        "_at_once",
        "_attempts",
        "_burst",
        "_due_s",
        "_heard",
        "_pending",
        "_rates_hz",
        "_retries_left",
        "_watch_from_s",
        "_watched",
    )

    def __init__(self, rates_hz: Mapping[int, float], at_once: Collection[int] = ()) -> None:
        """Request ``rates_hz``; first those of ``at_once`` together, before each is confirmed in turn."""
        self._rates_hz = dict(rates_hz)
        self._at_once = at_once
        self._burst: list[int] = []
        self._pending: deque[int] = deque()
        self._attempts = 0
        self._due_s = -math.inf
        self._watch_from_s = math.inf
        self._watched = 0
        self._heard: set[int] = set()
        self._retries_left: dict[int, int] = {}
        self.restart()

    def restart(self) -> None:
        """Request everything again."""
        self._pending = deque(self._rates_hz)
        self._burst = [message_id for message_id in self._rates_hz if message_id in self._at_once]
        self._attempts = 0
        self._due_s = -math.inf
        self._watch_from_s = math.inf
        self._retries_left = {
            message_id: _STREAM_RETRIES for message_id, rate_hz in self._rates_hz.items() if rate_hz > 0.0
        }

    def on_ack(self) -> None:
        """Continue with the next stream; one that the vehicle does not have is not requested again."""
        if self._pending and self._attempts:
            self._next()

    def on_message(self, message_id: int) -> None:
        """Count a received message."""
        self._heard.add(message_id)
        if message_id == _WATCHED:
            self._watched += 1

    def due(self, now_s: float) -> list[tuple[int, float]]:
        """Return (message id, interval in microseconds, -1 for off) of the streams to request now."""
        stream = self._next_due(now_s)
        due = [] if stream is None else [stream]
        if self._burst:
            burst, self._burst = self._burst, []
            due = [(message_id, self._interval_us(message_id)) for message_id in burst] + due
        return due

    def _next_due(self, now_s: float) -> tuple[int, float] | None:
        """Return the stream whose turn it is, when it is time to request it."""
        if self._pending and self._attempts >= _ATTEMPTS and now_s >= self._due_s:
            self._next()
        if not self._pending:
            self._watch(now_s)
            return None
        if now_s < self._due_s:
            return None
        self._attempts += 1
        self._due_s = now_s + _ACK_TIMEOUT_S
        message_id = self._pending[0]
        return message_id, self._interval_us(message_id)

    def _interval_us(self, message_id: int) -> float:
        rate_hz = self._rates_hz[message_id]
        return 1e6 / rate_hz if rate_hz else -1.0

    def _next(self) -> None:
        self._pending.popleft()
        self._attempts = 0
        self._due_s = -math.inf

    def _watch(self, now_s: float) -> None:
        if math.isinf(self._watch_from_s):
            self._begin_to_watch(now_s)
        elif now_s - self._watch_from_s >= _WATCH_S:
            expected = self._rates_hz.get(_WATCHED, 0.0) * (now_s - self._watch_from_s)
            is_rare = self._watched < _LOWEST_SHARE * expected
            missing = [
                message_id for message_id, left in self._retries_left.items() if left and message_id not in self._heard
            ]
            self._begin_to_watch(now_s)
            if is_rare:
                self.restart()
                return
            for message_id in missing:
                self._retries_left[message_id] -= 1
                self._pending.append(message_id)

    def _begin_to_watch(self, now_s: float) -> None:
        self._watch_from_s, self._watched = now_s, 0
        self._heard.clear()


@dataclass(slots=True)
class _Request:
    pause_s: float
    attempts_left: float
    due_s: float = -math.inf


class OneTimeRequests:
    """Messages requested (REQUEST_MESSAGE) until they arrive. Bounded by the few ids that are wanted."""

    __slots__ = ("_open",)

    def __init__(self) -> None:
        self._open: dict[tuple[int, int], _Request] = {}

    def want(self, component_id: int, message_id: int, pause_s: float, attempts: float = math.inf) -> None:
        """Request a message of ``component_id`` every ``pause_s``, at most ``attempts`` times."""
        self._open[component_id, message_id] = _Request(pause_s, attempts)

    def on_message(self, component_id: int, message_id: int) -> None:
        """Stop requesting a message that has arrived."""
        if self._open:
            self._open.pop((component_id, message_id), None)

    def poll(self, now_s: float) -> list[tuple[int, int]]:
        """Return (component id, message id) of the requests to send now."""
        if not self._open:
            return []
        due = [key for key, request in self._open.items() if now_s >= request.due_s]
        for key in due:
            request = self._open[key]
            request.attempts_left -= 1
            request.due_s = now_s + request.pause_s
            if request.attempts_left <= 0:
                del self._open[key]
        return due


def higher_rates(rates_hz: Mapping[int, float], more_hz: Mapping[int, float]) -> dict[int, float]:
    """Return the higher of both rates of each message."""
    return {key: max(rates_hz.get(key, 0.0), more_hz.get(key, 0.0)) for key in [*rates_hz, *more_hz]}
