"""What later collections of the service's garbage leave out."""

from __future__ import annotations

import gc
import weakref

from aos_gcs.runtime.garbage import settle_garbage


class Node:
    """Something that refers to itself."""

    def __init__(self) -> None:
        self.itself = self


def test_what_exists_is_left_out_and_what_comes_later_is_collected() -> None:
    before = Node()
    settle_garbage()
    assert not any(found is before for found in gc.get_objects())
    later = Node()
    assert any(found is later for found in gc.get_objects())
    lives = weakref.ref(later)
    del later
    gc.collect()
    assert lives() is None


def test_the_next_sortie_collects_what_the_former_one_has_left() -> None:
    former = Node()
    settle_garbage()
    lives = weakref.ref(former)
    del former
    gc.collect()
    assert lives() is not None
    settle_garbage()
    assert lives() is None
