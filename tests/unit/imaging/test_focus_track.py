import math

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.focus.autofocus import FocusResult
from aos_gcs.imaging.focus.track import FocusTrack, overridden, search_range_m, update_focus


def found(height_m: float, sigma_m: float = 0.5) -> FocusResult:
    return FocusResult(Plane(height_m), height_m, 0.9, sigma_m, 0.1, True, "")


NOTHING = FocusResult(Plane(7.0), 7.0, 0.0, math.inf, 0.0, False, "the agreement may be chance")


def test_a_guess_gives_way_to_the_first_result() -> None:
    track = update_focus(FocusTrack(0.0, math.inf), found(4.0))
    assert track.height_m == 4.0
    assert track.sigma_m == pytest.approx(0.5)


def test_results_are_averaged_and_the_estimate_gets_surer() -> None:
    track = FocusTrack(0.0, math.inf)
    for offset_m in (0.6, -0.6) * 10:
        track = update_focus(track, found(3.0 + offset_m), drift_m=0.05)
    assert track.height_m == pytest.approx(3.0, abs=0.25)
    assert track.sigma_m < 0.25


def test_it_follows_terrain_that_rises_slowly() -> None:
    track = FocusTrack(0.0, 0.5)
    for step in range(40):
        track = update_focus(track, found(0.1 * step))
    assert track.height_m == pytest.approx(3.9, abs=0.5)


def test_an_operators_height_stays_where_others_count_from_elsewhere() -> None:
    track = overridden(FocusTrack(1.0, 0.5), 4.0).moved(7.0)
    assert (track.height_m, track.override_m) == (8.0, 4.0)


def test_one_wrong_result_is_doubted() -> None:
    track = update_focus(FocusTrack(2.0, 0.2), found(12.0))
    assert track.height_m == 2.0
    assert track.doubted == 1
    track = update_focus(track, found(2.1))
    assert track.height_m == pytest.approx(2.0, abs=0.1)
    assert track.doubted == 0


def test_results_that_insist_are_believed() -> None:
    track = FocusTrack(2.0, 0.2)
    heights_m = []
    for _ in range(4):
        track = update_focus(track, found(12.0))
        heights_m.append(track.height_m)
    assert heights_m == [2.0, 2.0, 12.0, pytest.approx(12.0)]


def test_nothing_found_only_lets_the_uncertainty_grow() -> None:
    track = update_focus(FocusTrack(2.0, 0.3), NOTHING, drift_m=0.4)
    assert (track.height_m, track.missed) == (2.0, 1)
    assert track.sigma_m == pytest.approx(0.5)
    assert update_focus(track, found(2.0)).missed == 0


def test_the_operator_overrules_and_gives_back() -> None:
    track = overridden(FocusTrack(2.0, 0.2), 5.0)
    track = update_focus(track, found(2.2))
    assert track.override_m == 5.0
    track = overridden(track, None)
    assert track.override_m is None
    assert track.height_m == pytest.approx(2.0, abs=0.2)
    with pytest.raises(ConfigurationError, match="finite"):
        overridden(track, math.nan)


def test_a_sure_height_narrows_the_search() -> None:
    assert search_range_m(FocusTrack(3.0, math.inf), -5.0, 10.0) == (-5.0, 10.0)
    assert search_range_m(FocusTrack(3.0, 0.1), -5.0, 10.0) == (1.0, 5.0)
    assert search_range_m(FocusTrack(9.0, 1.0), -5.0, 10.0) == (5.0, 10.0)
    assert search_range_m(FocusTrack(3.0, 0.1, doubted=1), -5.0, 10.0) == (-5.0, 10.0)
    assert search_range_m(FocusTrack(3.0, 0.1, missed=1), -5.0, 10.0) == (-5.0, 10.0)
    assert search_range_m(FocusTrack(40.0, 0.1), -5.0, 10.0) == (-5.0, 10.0)
