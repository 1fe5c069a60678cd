"""Integrals at the size of their pictures."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.focal_plane import choose_grid
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.pictures import MAX_CELLS, picture_shape
from aos_gcs.imaging.step.integration import integrate

CAMERA = CameraModel.from_fov(128, 128, np.radians(50.0))


def frames(dtype: type[np.generic]) -> list[Frame]:
    """Three frames of a smooth ground, turned against each other."""
    made = []
    for index in range(3):
        pose = nadir_pose([2.0 * index, 0.0, 30.0], 0.4 * index)
        u, v = np.meshgrid(np.arange(128), np.arange(128))
        right, down = (u - CAMERA.cx_px) / CAMERA.fx_px, (v - CAMERA.cy_px) / CAMERA.fy_px
        rays = np.dstack((right, down, np.ones(u.shape))) @ pose.R_cam2enu.T
        ground = pose.position_enu_m[:2] + 30.0 * rays[:, :, :2]
        values = 120.0 + 60.0 * np.sin(ground[:, :, 0] / 2.0) * np.cos(ground[:, :, 1] / 3.0)
        made.append(Frame(index, values[:, :, np.newaxis].astype(dtype), ("thermal",), pose, CAMERA))
    return made


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize("factor", [0.35, 0.5, 0.8])
def test_a_coarser_integral_shows_the_same_ground(dtype: type[np.generic], factor: float) -> None:
    grid = choose_grid(frames(dtype), 0.0)
    shape = round(grid.rows * factor), round(grid.columns * factor)
    whole, coarse = integrate(frames(dtype), grid), integrate(frames(dtype), grid, shape)
    assert coarse.mean.shape == (*shape, 1)
    known = (whole.coverage > 0).astype(np.float32)
    values = np.where(known[:, :, np.newaxis] > 0, whole.mean, 0.0)
    expected, share = (cv2.resize(one, shape[::-1], interpolation=cv2.INTER_AREA) for one in (values, known))
    inside = share > 0.999
    assert inside.mean() > 0.4
    assert (coarse.coverage[inside] > 0).all()
    error = np.abs(coarse.mean[:, :, 0] - expected)[inside]
    assert error.mean() < 1.0
    assert error.max() < 8.0


def test_a_gap_stays_as_small_as_it_is() -> None:
    gaps = frames(np.float32)[:1]
    gaps[0].image[60:63, 60:63] = np.nan
    grid = choose_grid(gaps, 0.0)
    shape = grid.rows // 4, grid.columns // 4
    missing = ~np.isfinite(integrate(gaps, grid, shape).mean)
    whole = ~np.isfinite(integrate(frames(np.float32)[:1], grid, shape).mean)
    assert 1 <= np.count_nonzero(missing) - np.count_nonzero(whole) <= 9


def test_small_rasters_are_pictures_as_they_are() -> None:
    assert picture_shape(300, 400) == (300, 400)
    rows, columns = picture_shape(2000, 1000)
    assert rows * columns == pytest.approx(MAX_CELLS, rel=0.01)
    assert rows / columns == pytest.approx(2.0, rel=0.01)
