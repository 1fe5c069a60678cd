"""Status texts, which may come in several packets."""

from __future__ import annotations

from collections import OrderedDict

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.ports import Severity

_CHUNK_SIZE = 50
_MAX_CHUNKS = 8
_MAX_OPEN_TEXTS = 4
_CHUNK_TIMEOUT_S = 1.0
_ARMING_PREFIXES = ("PreArm:", "Arm:", "Preflight Fail:", "Arming denied")


class _OpenText:
    def __init__(self, severity: int, now_s: float) -> None:
        self.severity = severity
        self.started_s = now_s
        self.chunks: dict[int, str] = {}
        self.last: int | None = None

    @property
    def is_complete(self) -> bool:
        return self.last is not None and all(number in self.chunks for number in range(self.last + 1))

    def text(self) -> str:
        return "".join(self.chunks[number] for number in sorted(self.chunks))


class StatusTexts:
    """Joins the chunks of one vehicle's texts. Policy when too many are open: the oldest is returned incomplete."""

    def __init__(self) -> None:
        self._open: OrderedDict[int, _OpenText] = OrderedDict()

    def feed(self, message: mavlink.MAVLink_statustext_message, now_s: float) -> list[tuple[int, str]]:
        """Return (MAV_SEVERITY, text) of each text that is now complete."""
        text = "".join(character if character.isprintable() else " " for character in message.text)
        if message.id == 0:
            return [(message.severity, text)]
        finished = []
        entry = self._open.get(message.id)
        if entry is None:
            if len(self._open) >= _MAX_OPEN_TEXTS:
                finished.append(self._take(next(iter(self._open))))
            entry = self._open[message.id] = _OpenText(message.severity, now_s)
        if message.chunk_seq < _MAX_CHUNKS:
            entry.chunks[message.chunk_seq] = text
        if len(text) < _CHUNK_SIZE or message.chunk_seq >= _MAX_CHUNKS - 1:
            entry.last = min(message.chunk_seq, _MAX_CHUNKS - 1)
        if entry.is_complete:
            finished.append(self._take(message.id))
        return finished

    def poll(self, now_s: float) -> list[tuple[int, str]]:
        """Return the texts whose missing chunks are overdue."""
        if not self._open:
            return []
        late = [text_id for text_id, entry in self._open.items() if now_s - entry.started_s > _CHUNK_TIMEOUT_S]
        return [self._take(text_id) for text_id in late]

    def _take(self, text_id: int) -> tuple[int, str]:
        entry = self._open.pop(text_id)
        return entry.severity, entry.text()


def is_about_arming(text: str) -> bool:
    """Return whether a text says why the vehicle cannot be armed: over once it is armed."""
    return text.startswith(_ARMING_PREFIXES)


def notice_severity(mav_severity: int, text: str) -> Severity:
    """Return the severity of a notice for a text of MAV_SEVERITY.

    Why a vehicle cannot be armed is no alert, which would stay open in flight: the check *ready to arm* shows it for as
    long as it holds.
    """
    if is_about_arming(text):
        return Severity.INFO
    if mav_severity <= mavlink.MAV_SEVERITY_CRITICAL:
        return Severity.CRITICAL
    if mav_severity <= mavlink.MAV_SEVERITY_WARNING:
        return Severity.WARNING
    return Severity.INFO
