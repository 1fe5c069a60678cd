"""Garbage collection of the service: short, so that it holds neither links nor commands up."""

from __future__ import annotations

import gc


def settle_garbage() -> None:
    """Leave everything that exists now out of later collections, after a last one.

    Call it before links are opened, in each sortie. A collection looks through all objects that were made before, of
    which modules have more than 100,000, and no other thread runs meanwhile.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
