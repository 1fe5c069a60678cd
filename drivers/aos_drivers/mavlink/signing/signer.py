"""MAVLink 2 signing (https://mavlink.io/en/guide/message_signing.html), without I/O.

pymavlink signs what we send. What we receive is verified here: unlike pymavlink's own check, a forged packet moves no
state, and the memory of senders is bounded.
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Callable, Mapping
from enum import Enum, auto

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.framing import is_signed

KEY_BYTES = 32
_EPOCH_UTC_S = 1_420_070_400
"""2015-01-01, from which signatures count time."""
TICKS_PER_S = 100_000
_NEW_STREAM_TICKS = 60 * TICKS_PER_S
"""Greatest delay of a sender's first packet behind our time."""
_SIGNATURE_BYTES = 6
_STAMP_BYTES = 6
_MAX_STREAMS = 4096
_MAX_TICKS = 2 ** (8 * _STAMP_BYTES) - 1
FAR_TICKS = _MAX_TICKS - 10 * 366 * 86_400 * TICKS_PER_S
"""Latest credible signature time, in the year 2094. Ours follows no later one: it has to grow for years to come."""

Stream = tuple[int, int, int]
"""Link id, system and component of a sender."""


class SignatureCheck(Enum):
    """Result of checking a packet's signature."""

    GOOD = auto()
    UNSIGNED = auto()
    WRONG_KEY = auto()
    REPLAYED = auto()
    """Signed with our key, but not newer than earlier packets or, for a new sender, late by more than a minute."""
    FAR_AHEAD = auto()
    """Signed with our key, but with a time that no clock should show."""

    __hash__ = object.__hash__  # members are unique: Enum's own, of their names, takes longer than the rest of counting


def ticks_of(utc_s: float) -> int:
    """Return the signature time (10 microseconds since 2015) of seconds since the Unix epoch."""
    return max(0, round((utc_s - _EPOCH_UTC_S) * TICKS_PER_S))


class SigningClock:
    """Signature times, which must never run backwards: not when the computer's clock does, nor over restarts."""

    def __init__(self, utc_s: Callable[[], float], at_least_ticks: int) -> None:
        """Take the clock and the time up to which an earlier run may have signed."""
        self._utc_s = utc_s
        self.latest_ticks = at_least_ticks

    def next_ticks(self) -> int:
        """Return the time for the next packet, later than all before."""
        self.latest_ticks = min(max(self.latest_ticks + 1, ticks_of(self._utc_s())), _MAX_TICKS)
        return self.latest_ticks

    def now_ticks(self) -> int:
        """Return the present time."""
        return max(self.latest_ticks, ticks_of(self._utc_s()))

    def advance(self, ticks: int) -> None:
        """Continue from the time of another sender with the same key, whose clock is ahead of ours."""
        self.latest_ticks = max(self.latest_ticks, ticks)


class StreamMemory:
    """Time of the latest packet of each sender with one key, on whatever link it came.

    Bounded to 4096 senders; one that was forgotten has to be up to date within a minute, like a new one.
    """

    def __init__(self, latest_ticks: Mapping[Stream, int] | None = None) -> None:
        """Continue with the times that an earlier run has stored."""
        self.latest_ticks = dict(latest_ticks or {})
        self.changes = 0
        """Number of packets noted."""

    def note(self, stream: Stream, ticks: int) -> None:
        """Remember the time of a sender's latest packet."""
        self.changes += 1
        self.latest_ticks.pop(stream, None)  # the latest sender stands last
        self.latest_ticks[stream] = ticks
        if len(self.latest_ticks) > _MAX_STREAMS:
            del self.latest_ticks[next(iter(self.latest_ticks))]


class LinkSigner:
    """The signing of one link: one key, and the memory of the senders with it.

    Links with one key share the memory: a packet recorded on one of them is a replay on every other.
    """

    def __init__(
        self, link: int, key: bytes, clock: SigningClock, accepts_unsigned: bool, memory: StreamMemory | None = None
    ) -> None:
        self._link_id = link % 256
        self._key = key
        self._keyed = hashlib.sha256(key)
        self._clock = clock
        self._accepts_unsigned = accepts_unsigned
        self._memory = memory or StreamMemory()
        self.counts = dict.fromkeys(SignatureCheck, 0)
        """Packets received, by the result of their check."""

    def with_empty_memory(self) -> LinkSigner:
        """Return another signer of the same link that has not received anything yet."""
        return LinkSigner(self._link_id, self._key, self._clock, self._accepts_unsigned)

    def prepare(self, encoder: mavlink.MAVLink) -> None:
        """Let ``encoder`` sign the next packet."""
        signing = encoder.signing
        signing.secret_key, signing.link_id, signing.sign_outgoing = self._key, self._link_id, True
        signing.timestamp = self._clock.next_ticks()

    def check(self, message: mavlink.MAVLink_message) -> SignatureCheck:
        """Check the signature of a packet, and count the result."""
        packet = message.get_msgbuf()
        if type(packet) is not bytes:
            packet = bytes(packet)
        check = self.verify(packet, (message.get_srcSystem(), message.get_srcComponent()))
        self.counts[check] += 1
        return check

    def accepts(self, check: SignatureCheck, message: mavlink.MAVLink_message) -> bool:
        """Whether the packet may be used. Radios of a link insert their own state, and have no key."""
        is_radio = message.get_msgId() == mavlink.MAVLINK_MSG_ID_RADIO_STATUS
        return check is SignatureCheck.GOOD or (
            check is SignatureCheck.UNSIGNED and (self._accepts_unsigned or is_radio)
        )

    def verify(self, packet: bytes, sender: tuple[int, int]) -> SignatureCheck:
        """Check the signature of a packet from ``sender`` (system, component)."""
        if not is_signed(packet):
            return SignatureCheck.UNSIGNED
        body, signature = packet[:-_SIGNATURE_BYTES], packet[-_SIGNATURE_BYTES:]
        digest = self._keyed.copy()
        digest.update(body)
        if not hmac.compare_digest(digest.digest()[:_SIGNATURE_BYTES], signature):
            return SignatureCheck.WRONG_KEY
        ticks = int.from_bytes(body[-_STAMP_BYTES:], "little")
        if ticks > FAR_TICKS:
            return SignatureCheck.FAR_AHEAD
        stream = body[-_STAMP_BYTES - 1], sender[0], sender[1]
        latest = self._memory.latest_ticks.get(stream)
        oldest = latest + 1 if latest is not None else self._clock.now_ticks() - _NEW_STREAM_TICKS
        if ticks < oldest:
            return SignatureCheck.REPLAYED
        self._memory.note(stream, ticks)
        self._clock.advance(ticks)
        return SignatureCheck.GOOD
