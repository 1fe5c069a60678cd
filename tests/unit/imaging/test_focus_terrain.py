"""The offset of a terrain by what frames say about it, and by how sure its height was before."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.focus.autofocus import FocusCurve
from aos_gcs.imaging.focus.region import GroundRegion, ViewRegion
from aos_gcs.imaging.focus.terrain import MIN_SIGMA_M, TERRAIN_SIGMA_M, find_terrain_focus, judge_offsets
from aos_gcs.imaging.surfaces.terrain import Terrain

OFFSETS_M = np.linspace(-5.0, 5.0, 41)
SLOPE = Terrain(-50.0, -50.0, 50.0, np.array([[-10.0, 0.0, 10.0]] * 3))


def curve(significance: float, at_m: float) -> FocusCurve:
    values: NDArray[np.float64] = 0.001 * significance * np.exp(-0.5 * ((OFFSETS_M - at_m) / 0.7) ** 2)
    return FocusCurve(values, 0.001)


def test_frames_that_say_nothing_leave_the_terrain_where_it_is() -> None:
    result = judge_offsets(OFFSETS_M, curve(0.0, 2.0))
    assert not result.by_frames
    assert result.offset_m == pytest.approx(0.0, abs=1e-9)
    assert result.sigma_m == pytest.approx(TERRAIN_SIGMA_M, rel=0.05)


@pytest.mark.parametrize("at_m", [-3.0, 0.0, 2.0])
def test_a_significant_peak_is_taken(at_m: float) -> None:
    result = judge_offsets(OFFSETS_M, curve(9.0, at_m))
    assert result.by_frames
    assert result.offset_m == pytest.approx(at_m, abs=0.3)
    assert result.sigma_m == MIN_SIGMA_M


def test_a_faint_peak_far_off_is_not_believed() -> None:
    result = judge_offsets(OFFSETS_M, curve(2.0, 4.5))
    assert abs(result.offset_m) < 1.0


def test_equal_rivals_make_it_uncertain() -> None:
    values = curve(9.0, -2.0).values + curve(9.0, 2.0).values
    result = judge_offsets(OFFSETS_M, FocusCurve(values, 0.001))
    assert result.sigma_m > 1.5
    assert not result.by_frames


def test_frames_that_do_not_overlap_say_nothing() -> None:
    assert not judge_offsets(OFFSETS_M, FocusCurve(curve(9.0, 2.0).values, math.inf)).by_frames


def test_regions_lie_on_terrain() -> None:
    camera = CameraModel.from_fov(320, 240, np.radians(55.0))
    for region in (GroundRegion(-6.0, -5.0, 6.0, 5.0), ViewRegion.whole(camera, nadir_pose([3.0, 4.0, 30.0]))):
        points_m = region.points_m(SLOPE)
        np.testing.assert_allclose(points_m[:, 2], 0.2 * points_m[:, 0], atol=1e-5)


def test_what_cannot_be_searched_is_refused() -> None:
    with pytest.raises(ImagingError, match="finite and ascending"):
        find_terrain_focus([], GroundRegion(0.0, 0.0, 1.0, 1.0), SLOPE, 3.0, 3.0)
    with pytest.raises(ImagingError, match="does not lie on the terrain"):
        find_terrain_focus([], GroundRegion(100.0, 0.0, 101.0, 1.0), SLOPE, -3.0, 3.0)
