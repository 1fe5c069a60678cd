"""All blobs of a step, each with the views it is made of."""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.detection.marks import Marks
from aos_gcs.imaging.model import FocalGrid, Frame
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.blobs import find_blobs
from aos_gcs.imaging.step.marking import MarkedFrame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.step.sightings import cells_by_frame

CAMERA = CameraModel.from_fov(128, 128, math.radians(50.0))
LARGE, SMALL = (3.0, -2.0, 0.0), (-5.0, 4.0, 0.0)


def look(vehicle_id: int, east_m: float, targets: dict[tuple[float, float, float], int]) -> Frame:
    """A frame with a warm square of a given half width, pixels, at each target."""
    pose = nadir_pose([east_m, 0.0, 30.0])
    image = np.random.default_rng(vehicle_id).normal(20.0, 1.0, (128, 128, 1)).astype(np.float32)
    for target, half in targets.items():
        u, v = np.round(project_points([target], CAMERA, pose)[0]).astype(int)
        image[v - half : v + half + 1, u - half : u + half + 1] += 60.0
    return Frame(vehicle_id, image, ("thermal",), pose, CAMERA)


def test_each_target_is_sighted_with_the_views_that_mark_it() -> None:
    frames = [look(1, -2.0, {LARGE: 2}), look(2, 0.0, {LARGE: 2, SMALL: 1}), look(3, 2.0, {})]
    analysis = analyse_step(frames, ImagingSettings(rx_quantile=0.99, agreeing_frames=1))
    large, small = analysis.sightings[:2]
    assert analysis.blob is large.blob
    assert [view.vehicle_id for view in large.views] == [1, 2]
    assert [view.vehicle_id for view in small.views] == [2]
    np.testing.assert_allclose(small.views[0].point_enu_m, SMALL[:2], atol=0.25)
    for view in large.views:
        np.testing.assert_allclose(view.point_enu_m, LARGE[:2], atol=0.25)
    fitness = dict(zip(analysis.vehicle_ids, analysis.fitness, strict=True))
    assert min(fitness[1], fitness[2]) > fitness[3] == 0.0


def test_each_frame_has_its_own_cells_of_each_blob() -> None:
    rng = np.random.default_rng(0)
    grid = FocalGrid(west_m=0.0, north_m=0.0, resolution_m=0.1, rows=40, columns=50, height_m=0.0)
    masks = rng.random((3, 40, 50)) < np.array([0.03, 0.0, 0.1])[:, np.newaxis, np.newaxis]
    blobs = find_blobs(masks.sum(axis=0).astype(np.uint16), gap_cells=0)
    marked = [MarkedFrame(look(i, 0.0, {}), Marks(*np.nonzero(mask))) for i, mask in enumerate(masks)]
    found = cells_by_frame(blobs, grid, marked)
    assert len(blobs) > 5
    for cells, by_frame in zip(blobs, found, strict=True):
        for mask, own in zip(masks, by_frame, strict=True):
            np.testing.assert_array_equal(own, np.flatnonzero(mask[cells.rows, cells.columns]))
    assert cells_by_frame([], grid, marked) == []


def test_the_views_together_are_the_centroid() -> None:
    analysis = analyse_step([look(i, 1.5 * i, {LARGE: 2}) for i in range(4)], ImagingSettings(rx_quantile=0.99))
    sighting = analysis.sightings[0]
    points_m = [view.point_enu_m for view in sighting.views]
    np.testing.assert_allclose(np.average(points_m, axis=0, weights=analysis.fitness), sighting.blob.centroid_enu_m[:2])
