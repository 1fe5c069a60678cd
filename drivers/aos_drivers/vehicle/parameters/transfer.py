"""Reading and writing a few parameters by name, never the whole list (https://mavlink.io/en/services/parameter.html)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target
from aos_drivers.vehicle.exchange import longer_pause_s
from aos_drivers.vehicle.parameters.encoding import Parameter, ParameterEncoding
from aos_gcs.errors import CommandRefusedError

REPEAT_S = 0.7
"""First pause before a request without an answer is sent again."""
_OPTIONAL_ATTEMPTS = 6
"""Requests after which an optional parameter is taken to be missing, where one that exists was answered each time."""
_MAX_REFUSALS = 4
"""Answers with another value than the written one after which the vehicle is taken to refuse it."""
_TOLERANCE = 1e-4


class ParameterRead:
    """Read of several parameters at the same time. A tuple holds old and new names, of which one has to exist."""

    name = "report its parameters"

    def __init__(
        self,
        target: Target,
        encoding: ParameterEncoding,
        required: Sequence[tuple[str, ...]],
        optional: Sequence[str] = (),
    ) -> None:
        self._target = target
        self._encoding = encoding
        self._required = tuple(required)
        self._optional = tuple(optional)
        self._attempts = 0
        self._is_witnessed = False
        """Whether the last request for a parameter that exists, beside those for optional ones, was answered."""
        self._pause_s = REPEAT_S
        self._requested = 0
        """Number of names in the last request."""
        self.due_s = -math.inf
        self.found: dict[str, Parameter] = {}
        """Parameters read so far, by name."""

    @property
    def is_done(self) -> bool:
        """Whether all required ones have arrived, and the optional ones have arrived or do not exist."""
        has_required = all(any(name in self.found for name in names) for names in self._required)
        has_optional = all(name in self.found for name in self._optional)
        return has_required and (has_optional or self._attempts > _OPTIONAL_ATTEMPTS)

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return the requests for all missing parameters."""
        if now_s < self.due_s:
            return []
        required, optional = self._missing(self._required), self._missing([(name,) for name in self._optional])
        witness = [] if required else list(self.found)[:1]
        self._attempts += self._is_witnessed or not self._required
        self._is_witnessed = False
        missing = [*required, *optional, *witness]
        is_stuck = bool(required) and len(missing) == self._requested
        self._pause_s = longer_pause_s(self._pause_s) if is_stuck else REPEAT_S
        self._requested = len(missing)
        self.due_s = now_s + self._pause_s
        return [
            mavlink.MAVLink_param_request_read_message(
                self._target.system_id, self._target.component_id, name.encode(), -1
            )
            for name in dict.fromkeys(missing)
        ]

    def _missing(self, groups: Sequence[tuple[str, ...]]) -> list[str]:
        return [name for names in groups if not any(name in self.found for name in names) for name in names]

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Process a PARAM_VALUE."""
        if message.get_msgId() != mavlink.MAVLINK_MSG_ID_PARAM_VALUE:
            return
        wanted = {*self._optional, *(name for names in self._required for name in names)}
        if message.param_id in wanted:
            value = self._encoding.decode(message.param_value, message.param_type)
            if math.isfinite(value):
                self._is_witnessed = message.param_id == next(iter(self.found), None)
                self.found[message.param_id] = Parameter(value, message.param_type)


class ParameterWrite:
    """Write of parameters that ends when the vehicle has repeated each with its new value."""

    name = "accept its parameters"

    def __init__(self, target: Target, encoding: ParameterEncoding, values: Mapping[str, Parameter]) -> None:
        self._target = target
        self._encoding = encoding
        self._open = dict(values)
        self._refusals: dict[str, int] = {}
        self._pause_s = REPEAT_S
        self._unanswered: set[str] = set()
        """Names written since the last answer. Further answers are late ones, to a read or to an earlier write."""
        self.due_s = -math.inf

    @property
    def is_done(self) -> bool:
        """Whether all are set."""
        return not self._open

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return a PARAM_SET for each that is not set yet.

        Raises:
            CommandRefusedError: the vehicle keeps another value.
        """
        refused = [name for name, count in self._refusals.items() if count >= _MAX_REFUSALS]
        if refused:
            raise CommandRefusedError(
                f"vehicle {self._target.system_id} does not accept {refused[0]} = {self._open[refused[0]].value:g}: "
                "set it manually"
            )
        if now_s < self.due_s:
            return []
        self.due_s = now_s + self._pause_s
        self._pause_s = longer_pause_s(self._pause_s)
        self._unanswered = set(self._open)
        return [
            mavlink.MAVLink_param_set_message(
                self._target.system_id,
                self._target.component_id,
                name.encode(),
                self._encoding.encode(parameter.value, parameter.kind),
                parameter.kind,
            )
            for name, parameter in self._open.items()
        ]

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Process a PARAM_VALUE."""
        if message.get_msgId() != mavlink.MAVLINK_MSG_ID_PARAM_VALUE or message.param_id not in self._open:
            return
        name = message.param_id
        value = self._encoding.decode(message.param_value, message.param_type)
        if math.isclose(value, self._open[name].value, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE):
            del self._open[name]
            self._refusals.pop(name, None)
        elif name in self._unanswered:
            self._unanswered.discard(name)
            self._refusals[name] = self._refusals.get(name, 0) + 1
