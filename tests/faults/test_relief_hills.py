"""Searches over hills of 60 m by simulated autopilots: never below the floor above ground, never too close together."""

from __future__ import annotations

import pytest

pytest.importorskip("rasterio")

from tests.campaign.relief import fly_over_hills

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
@pytest.mark.parametrize("follow", [False, True], ids=["level", "following"])
def test_hills_are_searched_above_the_floor_and_apart(autopilot: str, *, follow: bool) -> None:
    """Few vehicles and one seed; more of both: python -m tests.campaign.relief."""
    assert list(fly_over_hills(1, autopilot, follow=follow, vehicles=3).problems(3)) == []
