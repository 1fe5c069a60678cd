"""Acknowledgements of notices, and who made them."""

from __future__ import annotations

import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.acknowledgements import ACKNOWLEDGEMENTS_KEPT, Acknowledgements
from aos_gcs.mission.model.snapshot import Acknowledgement


def test_who_was_first_with_a_notice_stays_on_record() -> None:
    acknowledgements = Acknowledgements()
    assert acknowledgements.add([3, 1], "Ada", 100.0, last_notice_id=4)
    assert not acknowledgements.add([1, 3], "Bob", 200.0, last_notice_id=4)
    assert acknowledgements.add([3, 4], "Bob", 300.0, last_notice_id=4)
    assert acknowledgements.all() == (
        Acknowledgement(1, "Ada", 100.0),
        Acknowledgement(3, "Ada", 100.0),
        Acknowledgement(4, "Bob", 300.0),
    )


def test_with_a_notice_that_there_is_not_none_is_acknowledged() -> None:
    acknowledgements = Acknowledgements()
    with pytest.raises(MissionError, match="no notice 5 in this mission; the latest one is 4"):
        acknowledgements.add([2, 5], "Ada", 100.0, last_notice_id=4)
    assert acknowledgements.all() == ()


def test_only_the_latest_are_kept_and_old_ones_do_not_come_back() -> None:
    acknowledgements = Acknowledgements()
    latest = ACKNOWLEDGEMENTS_KEPT + 7
    acknowledgements.add(range(1, latest + 1), "Ada", 100.0, latest)
    assert [one.notice_id for one in acknowledgements.all()] == list(range(8, latest + 1))
    assert not acknowledgements.add([1], "Bob", 200.0, latest)
