"""Time since boot that one sender reports, and the reboots that it proves."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

BOOT_TIMED_IDS = frozenset({mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, mavlink.MAVLINK_MSG_ID_ATTITUDE})
"""Messages that hold the time since boot, as the first of their fields."""
_FIELD_BYTES = 4
REBOOT_MARGIN_MS = 2000
"""A packet that is older than the newest one by more than this is late, or of another boot."""
SAME_BOOT_S = 3.0
"""Moments of boot, as seen over two links of one vehicle, differ by no more than their delays do."""
SLACK_S = 5.0
"""Time by which a boot may seem to lie before the last packet of the boot before: simulated clocks may run faster."""
REBOOT_PACKETS = 3
"""Packets in a row that it takes to tell a reboot from a late packet."""
_JUMP_PACKETS = 10


class BootTime:
    """Time since boot of one sender.

    Networks deliver packets late and out of order, so one packet proves nothing. A reboot shows in several packets in
    a row that agree on a moment of boot after the last packet of the former one. What is merely late seems to come from
    a boot long before that.
    """

    __slots__ = ("_agreed_at_s", "_older", "booted_at_s", "newest_ms", "packets")

    def __init__(self) -> None:
        self.newest_ms = 0
        self.booted_at_s: float | None = None
        """Clock time of the boot; None before it is known."""
        self.packets = 0
        self._agreed_at_s: float | None = None
        """Time of the last packet of the present boot."""
        self._older: list[tuple[int, float]] = []
        """Packets in a row, boot time and arrival, that do not belong to the present boot."""

    def hear(self, boot_ms: int, now_s: float) -> bool:
        """Return whether this packet proves that the sender has restarted."""
        self.packets += 1
        if boot_ms + REBOOT_MARGIN_MS >= self.newest_ms:
            self.newest_ms = max(self.newest_ms, boot_ms)
            self.booted_at_s, self._agreed_at_s = now_s - boot_ms / 1000, now_s
            if self._older:
                self._older.clear()
            return False
        if self._older and not _is_same_boot(self._older[-1], (boot_ms, now_s)):
            self._older.clear()
        self._older = [*self._older, (boot_ms, now_s)][-_JUMP_PACKETS:]
        former_s = self._agreed_at_s if self._agreed_at_s is not None else now_s
        is_later = _booted_at_s(self._older[0]) >= former_s - SLACK_S
        if len(self._older) < (REBOOT_PACKETS if is_later else _JUMP_PACKETS):
            return False
        self.begin_anew(boot_ms, now_s)
        return is_later

    def begin_anew(self, boot_ms: int, now_s: float) -> None:
        """Count from another boot: that of the sender, or one proven at another address of the same vehicle."""
        self.newest_ms, self.booted_at_s, self._agreed_at_s = boot_ms, now_s - boot_ms / 1000, now_s
        self._older.clear()

    def follows(self, former: BootTime, former_heard_at_s: float) -> bool:
        """Return whether this is a later boot than that of a sender that fell silent at ``former_heard_at_s``."""
        if self.booted_at_s is None or former.booted_at_s is None:
            return False
        return self.booted_at_s > max(former.booted_at_s + SAME_BOOT_S, former_heard_at_s - SLACK_S)


def boot_ms_of(message: mavlink.MAVLink_message) -> int:
    """Return the time since boot (ms) of a received message of ``BOOT_TIMED_IDS``, without decoding the message."""
    packet = message.get_msgbuf()
    start = mavlink.HEADER_LEN_V2 if packet[0] == mavlink.PROTOCOL_MARKER_V2 else mavlink.HEADER_LEN_V1
    return int.from_bytes(packet[start : start + min(packet[1], _FIELD_BYTES)], "little")  # MAVLink 2 cuts zeros off


def _is_same_boot(one: tuple[int, float], other: tuple[int, float]) -> bool:
    return other[0] >= one[0] and abs(_booted_at_s(one) - _booted_at_s(other)) <= SAME_BOOT_S


def _booted_at_s(packet: tuple[int, float]) -> float:
    boot_ms, heard_at_s = packet
    return heard_at_s - boot_ms / 1000
