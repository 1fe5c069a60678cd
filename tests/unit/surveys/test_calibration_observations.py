"""Derivatives of what a calibration observes, against differences of the places themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.calibration.observations import COMMON, OWN, ObservationModel, Unknowns
from aos_gcs.surveys.calibration.tracks import FeatureTracks
from aos_gcs.surveys.motion import ImageMotion

IMAGES, POINTS = 4, 12
LENSES = [
    None,
    LensDistortion(LensModel.BROWN_CONRADY, (-0.2, 0.05, 0.002, -0.001, 0.01)),
    LensDistortion(LensModel.FISHEYE, (0.05, -0.01, 0.002, 0.0)),
]


def _model_and_unknowns(lens: LensDistortion | None, behind: bool) -> tuple[ObservationModel, Unknowns]:
    rng = np.random.default_rng(5)
    camera = replace(CameraModel.from_fov(640, 512, 1.0), distortion=lens)
    down = Rotation.from_euler("x", 180.0, degrees=True)
    turns = Rotation.from_rotvec(rng.normal(0.0, 0.2, (IMAGES, 3))) * down
    poses = [Pose(np.array([3.0 * k, 0.0, 30.0]), R) for k, R in enumerate(turns.as_matrix())]
    motion = replace(ImageMotion.none(IMAGES), velocity_mps=rng.normal(0.0, 4.0, (IMAGES, 3)))
    motion = replace(motion, acceleration_mps2=rng.normal(0.0, 1.0, (IMAGES, 3)))
    motion = replace(motion, rate_cam_radps=rng.normal(0.0, 0.5, (IMAGES, 3)))
    image, point = np.divmod(np.arange(IMAGES * POINTS), POINTS)
    tracks = FeatureTracks(image, point, np.zeros((len(image), 2)))
    points_m = rng.uniform((-5.0, -5.0, 0.0), (14.0, 5.0, 3.0), (POINTS, 3))
    if behind:
        points_m[0, 2] = 60.0
    common = np.array([0.03, -0.02, 0.04, 0.02, 0.01, -0.02, 0.08])
    return ObservationModel(tracks, camera, poses, motion), Unknowns(
        common, rng.normal(0.0, 0.02, (IMAGES, OWN)), points_m
    )


def _differences(model: ObservationModel, unknowns: Unknowns, field: str, index: int) -> NDArray[np.float64]:
    """Return the change of the places by one column of the unknowns, shape (k, 2)."""
    sides = []
    for step in (1e-5, -1e-5):
        moved = getattr(unknowns, field).copy()
        moved[..., index] += step
        sides.append(-model.residuals(replace(unknowns, **{field: moved})))
    return np.asarray((sides[0] - sides[1]) / 2e-5)


@pytest.mark.parametrize("lens", LENSES, ids=["pinhole", "brown", "fisheye"])
def test_derivatives_are_those_of_the_places(lens: LensDistortion | None) -> None:
    model, unknowns = _model_and_unknowns(lens, behind=False)
    J, J_point = model.derivatives(unknowns)
    expected = [_differences(model, unknowns, "common", index) for index in range(COMMON)]
    expected += [_differences(model, unknowns, "own", index) for index in range(OWN)]
    np.testing.assert_allclose(J, np.stack(expected, axis=2), rtol=1e-4, atol=1e-3)
    expected = [_differences(model, unknowns, "points_m", index) for index in range(3)]
    np.testing.assert_allclose(J_point, np.stack(expected, axis=2), rtol=1e-4, atol=1e-3)


def test_points_behind_a_camera_have_no_derivatives() -> None:
    model, unknowns = _model_and_unknowns(None, behind=True)
    J, J_point = model.derivatives(unknowns)
    is_first = np.arange(IMAGES * POINTS) % POINTS == 0
    assert np.isnan(J[is_first]).any(axis=(1, 2)).all()
    assert np.isfinite(J[~is_first]).all()
    assert np.isfinite(J_point[~is_first]).all()
