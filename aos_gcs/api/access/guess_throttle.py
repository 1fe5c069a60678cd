"""Limits on wrong operator codes. Operators who are signed in are not affected."""

from __future__ import annotations

import ipaddress
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from aos_gcs.token_bucket import TokenBucket

FREE_GUESSES: Final = 5
"""Wrong codes without a wait, per address; each further one doubles the wait."""
FIRST_WAIT_S: Final = 1.0
LONGEST_WAIT_S: Final = 60.0
FORGET_AFTER_S: Final = 900.0
"""Time after which the wrong codes of an address are forgotten."""
GUESSES_PER_MINUTE: Final = 60.0
"""Limit for all addresses together, except those of operators and of this machine: they can always sign in."""
ADDRESSES_KEPT: Final = 1024


@dataclass(slots=True)
class _Guesses:
    wrong: int
    latest_s: float
    open_at_s: float
    """Time at which the next code is accepted for comparison."""
    about: str | None
    """Account that all of them were about; None where they were about several."""


class GuessThrottle:
    """Counts wrong guesses per address and overall.

    Args:
        now_s: a clock that never jumps.
        is_known: whether operators have sent requests from an address: strangers' guesses do not keep it waiting.
    """

    def __init__(self, now_s: Callable[[], float], is_known: Callable[[str], bool] = lambda _: False) -> None:
        self._now_s = now_s
        self._is_known = is_known
        self._by_address: OrderedDict[str, _Guesses] = OrderedDict()
        self._budget = TokenBucket(GUESSES_PER_MINUTE / 60.0, GUESSES_PER_MINUTE)

    def wait_s(self, address: str) -> float:
        """Return how long an address has to wait before its next code; 0: not at all."""
        now_s, guesses = self._now_s(), self._by_address.get(group_of(address))
        own_s = 0.0 if guesses is None else guesses.open_at_s - now_s
        shared_s = 0.0 if self._is_free(address) else (1.0 - self._budget.left(now_s)) / self._budget.per_s
        return max(0.0, own_s, shared_s)

    def note_wrong(self, address: str, about: str = "") -> None:
        """Count a wrong guess.

        Args:
            address: source address of the guess.
            about: name of the account that it was about; nothing for the code of all.
        """
        now_s, key, name = self._now_s(), group_of(address), about.casefold()
        guesses = self._by_address.pop(key, None)
        if guesses is None or now_s - guesses.latest_s > FORGET_AFTER_S:
            guesses = _Guesses(0, now_s, now_s, name)
        wrong = guesses.wrong + 1
        # The exponent is bounded before it is used: an attacker's count is not.
        doublings = min(wrong - FREE_GUESSES, 16)
        wait_s = min(LONGEST_WAIT_S, FIRST_WAIT_S * 2.0 ** (doublings - 1)) if doublings > 0 else 0.0
        self._by_address[key] = _Guesses(wrong, now_s, now_s + wait_s, name if guesses.about == name else None)
        if len(self._by_address) > ADDRESSES_KEPT:
            self._by_address.popitem(last=False)
        if not self._is_free(address):
            self._budget.left(now_s)
            self._budget.spend(1.0)

    def note_right(self, address: str, about: str = "") -> None:
        """Forget the wrong guesses of an address about an account; of others, only that this one was counted.

        Else somebody with an account could guess the passwords of others without a wait, by signing in between.
        """
        guesses = self._by_address.get(group_of(address))
        if guesses is not None and guesses.about == about.casefold():
            del self._by_address[group_of(address)]
        elif guesses is not None:
            guesses.wrong -= 1

    def _is_free(self, address: str) -> bool:
        """Return whether an address has no part in the budget of all."""
        return _is_here(address) or self._is_known(address)


def _is_here(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


@lru_cache(maxsize=ADDRESSES_KEPT)
def group_of(address: str) -> str:
    """Return the unit that is counted: for IPv6 the network, since one machine may use any address in it."""
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv4Address):
        return str(parsed)
    return str(parsed.ipv4_mapped or ipaddress.ip_network((parsed, 64), strict=False))
