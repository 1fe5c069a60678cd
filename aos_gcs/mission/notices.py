"""Choice of the notices that are kept for operators who look later; the record has all."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, Protocol, TypeVar

from aos_gcs.ports import Severity

NOTICES_KEPT: Final = 200


class _Notice(Protocol):
    @property
    def notice_id(self) -> int: ...
    @property
    def severity(self) -> Severity: ...
    @property
    def text(self) -> str: ...
    @property
    def vehicle_id(self) -> int | None: ...


AnyNotice = TypeVar("AnyNotice", bound=_Notice)

_RANK = {Severity.WARNING: 2, Severity.NEWS: 2, Severity.CRITICAL: 3}


def notices_to_keep(
    notices: Sequence[AnyNotice], acknowledged_ids: Iterable[int], capacity: int = NOTICES_KEPT
) -> list[AnyNotice]:
    """Return at most ``capacity`` of ``notices``, in their order.

    Information is dropped first, then what has been acknowledged or said again, then warnings, and critical notices
    that nobody has acknowledged last; of the same rank the oldest first.
    """
    excess = len(notices) - capacity
    if excess <= 0:
        return list(notices)
    dropped = set(sorted(range(len(notices)), key=_ranks(notices, frozenset(acknowledged_ids)).__getitem__)[:excess])
    return [notice for index, notice in enumerate(notices) if index not in dropped]


def _ranks(notices: Sequence[AnyNotice], acknowledged_ids: frozenset[int]) -> list[int]:
    """Return the importance of each notice; an acknowledgement covers earlier ones with the same words."""
    said_later: set[tuple[int | None, str]] = set()
    ranks = []
    for notice in reversed(notices):
        key = notice.vehicle_id, notice.text
        is_open = key not in said_later and notice.notice_id not in acknowledged_ids
        said_later.add(key)
        rank = _RANK.get(notice.severity, 0)
        ranks.append(rank if is_open or rank == 0 else 1)
    return ranks[::-1]
