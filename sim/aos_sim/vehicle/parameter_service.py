"""The parameter protocol of one autopilot."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.vehicle.parameters import ParameterEncoding, ParameterTable

PER_TICK = 10
"""Parameters of a list sent in one tick, so that a download does not drown the telemetry."""


class ParameterService:
    """Answers PARAM_REQUEST_LIST, PARAM_REQUEST_READ and PARAM_SET.

    Unknown names stay unanswered, as on the real autopilots. A second list request restarts the download.
    """

    def __init__(
        self,
        table: ParameterTable,
        encoding: ParameterEncoding,
        send: Callable[[mavlink.MAVLink_message], None],
        on_set: Callable[[], None],
    ) -> None:
        self._table = table
        self._encoding = encoding
        self._send = send
        self._notify_set = on_set
        self._to_be_sent: deque[str] = deque()

    def on_request_list(self, _: mavlink.MAVLink_message) -> None:
        """Begin to send all parameters."""
        self._to_be_sent = deque(self._table.names())

    def on_request_read(self, message: mavlink.MAVLink_message) -> None:
        """Send one parameter, by index or (index -1) by name."""
        name = message.param_id if message.param_index < 0 else self._table.name_at(message.param_index)
        if name is not None and name in self._table:
            self._send(self._value(name))

    def on_set(self, message: mavlink.MAVLink_message) -> None:
        """Set one parameter and send the value that is now in force."""
        name = message.param_id
        if name not in self._table:
            return
        self._table[name] = self._encoding.decode(message.param_value, self._table.kind(name))
        self._notify_set()
        self._send(self._value(name))

    def send_some(self) -> None:
        """Send the next few parameters of a list under way."""
        for _ in range(min(PER_TICK, len(self._to_be_sent))):
            self._send(self._value(self._to_be_sent.popleft()))

    def _value(self, name: str) -> mavlink.MAVLink_message:
        kind = self._table.kind(name)
        return mavlink.MAVLink_param_value_message(
            param_id=name.encode(),
            param_value=self._encoding.encode(self._table[name], kind),
            param_type=kind.value,
            param_count=len(self._table),
            param_index=self._table.index(name),
        )
