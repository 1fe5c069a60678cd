import dataclasses

import numpy as np
import pytest

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.integral import integrate
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.trimmed import MEDIAN, integrate_trimmed
from aos_gcs.imaging.views import perspective_view

CAMERA = CameraModel.from_fov(40, 30, np.radians(50.0))
TERRAIN = Terrain(-50.0, -50.0, 1.0, np.random.default_rng(0).uniform(0.0, 1.0, (101, 101)))


def frames_of(count: int, spacing_m: float = 0.0) -> list[Frame]:
    rng = np.random.default_rng(1)
    poses = [nadir_pose([i * spacing_m, 0.0, 30.0]) for i in range(count)]
    return [
        Frame(i, rng.integers(0, 255, (30, 40, 2), dtype=np.uint8), ("a", "b"), p, CAMERA) for i, p in enumerate(poses)
    ]


@pytest.mark.parametrize("count", [1, 2, 5, 8])
@pytest.mark.parametrize("trim", [0.0, 0.13, 0.25, MEDIAN])
def test_the_middle_values_are_averaged(count: int, trim: float) -> None:
    frames = frames_of(count)
    integral, coverage = integrate_trimmed(frames, perspective_view(CAMERA, frames[0].pose, 0.0), trim)
    images = np.stack([frame.image for frame in frames])
    cut = int(trim * count)
    kept = np.sort(images, axis=0)[cut : count - cut]
    expected = np.median(images, axis=0) if trim == MEDIAN else kept.mean(axis=0)
    assert (coverage == count).all()
    np.testing.assert_allclose(integral, expected, atol=1e-4)


@pytest.mark.parametrize("surface", [0.0, TERRAIN], ids=["plane", "terrain"])
@pytest.mark.parametrize("exact", [True, False])
def test_without_trim_it_is_the_mean_whatever_the_memory(surface: float | Terrain, exact: bool) -> None:
    frames = frames_of(4, spacing_m=6.0)
    view = perspective_view(CAMERA, nadir_pose([0.0, 0.0, 40.0]), surface)
    mean, count = integrate(frames, view, exact=exact)
    assert 0 in count
    # The fast way may round where it samples to a 32nd of a pixel, and neighbouring pixels differ by up to 255.
    atol = 1e-3 if exact else 255.0 / 32.0
    whole, _ = integrate_trimmed(frames, view, 0.0, exact=exact)
    np.testing.assert_allclose(whole, mean, atol=atol)
    for max_bytes in (1, 20_000):
        integral, coverage = integrate_trimmed(frames, view, 0.0, exact=exact, max_bytes=max_bytes)
        np.testing.assert_array_equal(coverage, count)
        np.testing.assert_allclose(integral, whole, atol=1e-3)


def test_a_glint_does_not_shine_through_the_median() -> None:
    frame = Frame(0, np.full((30, 40, 1), 50, dtype=np.uint8), ("grey",), nadir_pose([0, 0, 30]), CAMERA)
    glint = dataclasses.replace(frame, image=np.full((30, 40, 1), 255, dtype=np.uint8))
    view = perspective_view(CAMERA, frame.pose, 0.0)
    assert (integrate_trimmed([frame, glint, frame, frame, glint], view)[0] == 50.0).all()
    assert (integrate([frame, glint, frame, frame, glint], view)[0] == 132.0).all()


def test_bad_input_is_refused() -> None:
    frames = frames_of(2)
    view = perspective_view(CAMERA, frames[0].pose, 0.0)
    with pytest.raises(ValueError, match=r"trim must lie within \[0, 0.5\], got 0.6"):
        integrate_trimmed(frames, view, 0.6)
    with pytest.raises(ImagingError, match="no frame"):
        integrate_trimmed([], view)
    with pytest.raises(ImagingError, match="vehicle 1 has the bands"):
        integrate_trimmed([frames[0], dataclasses.replace(frames[1], bands=("a", "c"))], view)
