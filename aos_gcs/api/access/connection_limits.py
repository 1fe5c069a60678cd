"""Limits on connections, applied when they are accepted: many connections of others must not keep the operators out.

A connection counts for its address until it brings a request of an operator. Addresses from which operators have sent
requests are known: the totals do not count for them, and where their own number is used up, such as by an attacker
behind the same router, they may open more *on probation*. The first request of such a connection has to be an
operator's; when a newer connection needs the place, the oldest one without a request is closed.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable, Container
from dataclasses import dataclass, field
from typing import Final

from aos_gcs.api.access.guess_throttle import group_of
from aos_gcs.token_bucket import TokenBucket

CONNECTIONS_PER_PEER: Final = 64
"""Several browsers on one machine, each of which opens six."""
CONNECTIONS_IN_ALL: Final = 512
"""Connections of addresses without an operator."""
NEW_PER_S: Final = 100.0
NEW_AT_ONCE: Final = 512.0
"""Connections that addresses without an operator may open: each costs the service some work."""
ON_PROBATION: Final = 512
"""Browsers send their request at once, so that it is read before as many others have come."""
PEERS_KEPT: Final = 4096


def _nothing() -> None:
    """Close nothing."""


@dataclass(slots=True, eq=False)
class AcceptedConnection:
    """A connection that was accepted."""

    peer: str
    is_on_probation: bool
    close: Callable[[], None] = field(default=_nothing)
    """Closes the connection; set once there is something to close."""
    is_counted: bool = True


class ConnectionLimits:
    """Admits connections, and counts them per address.

    Args:
        now_s: clock in real seconds.
        exempt: addresses that are not counted, of proxies that speak for many clients.
    """

    def __init__(self, now_s: Callable[[], float], exempt: Container[str] = ()) -> None:
        self._now_s = now_s
        self._exempt = exempt
        self._counts: Counter[str] = Counter()
        self._in_all = 0
        self._new = TokenBucket(NEW_PER_S, NEW_AT_ONCE)
        self._known: OrderedDict[str, None] = OrderedDict()
        self._on_probation: OrderedDict[AcceptedConnection, None] = OrderedDict()

    def know(self, address: str) -> None:
        """Note that an operator is at this address."""
        peer = group_of(address)
        self._known[peer] = None
        self._known.move_to_end(peer)
        if len(self._known) > PEERS_KEPT:
            self._known.popitem(last=False)

    def is_known(self, address: str) -> bool:
        """Return whether an operator has sent requests from this address."""
        return group_of(address) in self._known

    def admit(self, address: str) -> AcceptedConnection | None:
        """Return the admission of a new connection, to be ended by ``leave``; None where it is refused."""
        peer = group_of(address)
        if address in self._exempt:
            return AcceptedConnection(peer, is_on_probation=False, is_counted=False)
        is_known, is_full = peer in self._known, self._counts[peer] >= CONNECTIONS_PER_PEER
        if not is_known and (is_full or self._in_all >= CONNECTIONS_IN_ALL or not self._new.take(1.0, self._now_s())):
            return None
        admission = AcceptedConnection(peer, is_on_probation=is_full)
        if is_full:
            self._try_out(admission)
        else:
            self._counts[peer] += 1
            self._in_all += 1
        return admission

    def trust(self, admission: AcceptedConnection) -> None:
        """Note that an operator uses a connection: from now on it does not count."""
        self.leave(admission)
        admission.is_on_probation = False

    def leave(self, admission: AcceptedConnection) -> None:
        """Count a connection no longer, once."""
        if not admission.is_counted:
            return
        admission.is_counted = False
        if admission.is_on_probation:
            self._on_probation.pop(admission, None)
            return
        self._in_all -= 1
        self._counts[admission.peer] -= 1
        if not self._counts[admission.peer]:
            del self._counts[admission.peer]

    def _try_out(self, admission: AcceptedConnection) -> None:
        if len(self._on_probation) >= ON_PROBATION:
            oldest, _ = self._on_probation.popitem(last=False)
            oldest.close()
        self._on_probation[admission] = None
