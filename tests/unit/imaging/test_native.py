"""The compiled kernels of imaging, beside the plain passes that they replace."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.detection.local_rx import local_rx_scores
from aos_gcs.imaging.detection.rx import rx_scores
from aos_gcs.imaging.focal_plane import covered_spans
from aos_gcs.imaging.integral import ViewIntegral, integrate
from aos_gcs.imaging.model import Frame, Pixels
from aos_gcs.imaging.native import kernels, library
from aos_gcs.imaging.points import PointView
from aos_gcs.imaging.step.marking import count_spans
from aos_gcs.imaging.views import FocalView, perspective_view

SCRIPT = Path(__file__).resolve().parents[3] / "scripts" / "build_kernels.py"
CAMERA = CameraModel.from_fov(150, 140, 0.9)

LENS = replace(CAMERA, distortion=LensDistortion(LensModel.BROWN_CONRADY, (-0.12, 0.02, 0.0, 0.0, 0.0)))

Result = TypeVar("Result")


@pytest.fixture(scope="module", autouse=True)
def _built() -> None:
    if library.loaded() is None:
        assert shutil.which("cc") is None, "The kernels are compiled before the first test: see tests/conftest.py."
        pytest.skip("There is no C compiler: the kernels have not been built.")


def without_kernels(work: Callable[[], Result]) -> Result:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(library, "loaded", lambda: None)
        return work()


def picture(dtype: str, bands: int, seed: int = 0) -> Pixels:
    rng = np.random.default_rng(seed)
    shades = rng.normal(size=(140, 150, bands)) @ (np.eye(bands) + 0.4)
    return np.ascontiguousarray((120 + 30 * shades).clip(0, 255).astype(dtype))


def frames(dtype: str, bands: int) -> list[Frame]:
    names = tuple(f"band {i}" for i in range(bands))
    poses = [nadir_pose([2.0 * i, 0.5 * i, 30.0 + i], 0.4 * i) for i in range(4)]
    # One that sees nothing of the raster.
    poses.append(nadir_pose([900.0, 0.0, 30.0]))
    return [Frame(i, picture(dtype, bands, i), names, pose, CAMERA) for i, pose in enumerate(poses)]


@pytest.mark.parametrize("camera", [CAMERA, LENS])
@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
@pytest.mark.parametrize("bands", [1, 3, 4, 6])
def test_warps_are_bilinear(dtype: str, bands: int, camera: CameraModel) -> None:
    taken = [replace(frame, camera=camera) for frame in frames(dtype, bands)]
    view = perspective_view(CAMERA, nadir_pose([1.0, 0.0, 31.0], 0.1), 0.0)
    mean, count = integrate(taken, view, exact=False)
    exact_mean, exact_count = integrate(taken, view)
    plain_count = without_kernels(lambda: integrate(taken, view, exact=False))[1]
    assert (count != plain_count).mean() <= (0.0 if camera is CAMERA else 2e-4)
    # OpenCV is no reference here: it interpolates two bands, and more than four, in steps of 1/32 pixel.
    same = count == exact_count
    assert same.mean() > 0.999
    # A lens is interpolated between whole pixels.
    np.testing.assert_allclose(mean[same], exact_mean[same], atol=0.01 if camera is CAMERA else 1.0)
    assert kernels.can_warp(taken[0].image)


def hilly_view() -> PointView:
    """Return a raster on hills, of which a part is not known, and a part lies above some cameras."""
    x_m, y_m = np.meshgrid(np.arange(-14.0, 15.0, 0.11), np.arange(-12.0, 13.0, 0.1))
    points_m = np.dstack((x_m, y_m, 2.0 * np.sin(0.5 * x_m) + np.cos(y_m)))
    points_m[20:60, 33:90] = np.nan
    points_m[200:, 200:, 2] += 31.5
    return PointView(points_m)


@pytest.mark.parametrize("camera", [CAMERA, LENS])
@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
@pytest.mark.parametrize("bands", [1, 3, 4, 6])
def test_points_are_sampled_bilinearly(dtype: str, bands: int, camera: CameraModel) -> None:
    taken, view = [replace(frame, camera=camera) for frame in frames(dtype, bands)], hilly_view()
    mean, count = integrate(taken, view, exact=False)
    exact_mean, exact_count = integrate(taken, view)
    plain_count = without_kernels(lambda: integrate(taken, view, exact=False))[1]
    assert (count != plain_count).mean() < 2e-4
    same = count == exact_count
    assert same.mean() > 0.999
    assert 0.1 < (count > 0).mean() < 0.95
    np.testing.assert_allclose(mean[same], exact_mean[same], atol=0.02 if camera is CAMERA else 1.0)


@pytest.mark.parametrize("added_one_by_one", [False, True])
def test_gaps_of_images_cover_no_points(added_one_by_one: bool) -> None:
    taken, view = frames("f4", 4), hilly_view()
    taken[1].image[20:40, 30:60] = np.nan
    taken[2].image[:, :, 3][70:80] = np.inf

    def sums() -> ViewIntegral:
        integral = ViewIntegral(view, taken[0].bands, exact=False)
        for own in [[frame] for frame in taken] if added_one_by_one else [taken]:
            integral.add_all(own)
        return integral

    own, plain = sums(), without_kernels(sums)
    assert (own.coverage != plain.coverage).mean() < 2e-4
    same = own.coverage == plain.coverage
    np.testing.assert_allclose(own.mean()[same], plain.mean()[same], atol=2.0)
    assert np.isfinite(own.mean()[own.coverage > 0]).all()


@pytest.mark.parametrize("view", [hilly_view(), perspective_view(CAMERA, nadir_pose([1.0, 0.0, 31.0]), 0.0)])
def test_sums_grow_by_finite_images_however_large(view: FocalView) -> None:
    small, large = frames("f4", 1)[:2]
    large.image[:] = 3e38
    integral = ViewIntegral(view, small.bands, exact=False)
    for own in (small, large, large):
        integral.add(own)
    alone = ViewIntegral(view, small.bands, exact=False)
    alone.add(small)
    only_small = (alone.coverage == 1) & (integral.coverage == 1)
    assert only_small.any()
    np.testing.assert_array_equal(integral.mean()[only_small], alone.mean()[only_small])
    assert integral.coverage.max() == 3


@pytest.mark.parametrize("camera", [CAMERA, LENS])
@pytest.mark.parametrize("bands", [1, 4])
def test_gaps_cover_nothing(bands: int, camera: CameraModel) -> None:
    taken = [replace(frame, camera=camera) for frame in frames("f4", bands)]
    taken[1].image[20:40, 30:60] = np.nan
    taken[2].image[:, :, bands - 1][70:80] = np.inf
    view = perspective_view(CAMERA, taken[0].pose, 0.0)
    mean, count = integrate(taken, view, exact=False)
    plain_mean, plain_count = without_kernels(lambda: integrate(taken, view, exact=False))
    same = count == plain_count
    assert same.mean() >= (1.0 if camera is CAMERA else 0.999)
    np.testing.assert_allclose(mean[same], plain_mean[same], atol=0.01 if camera is CAMERA else 1.0)


@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
@pytest.mark.parametrize("bands", [1, 3, 4, 6])
def test_means_in_one_pass_are_those_of_sums(dtype: str, bands: int) -> None:
    taken = frames(dtype, bands)
    view = perspective_view(CAMERA, nadir_pose([1.0, 0.0, 31.0], 0.1), 0.0)
    sums = ViewIntegral(view, taken[0].bands, exact=False)
    sums.add_all(taken)
    mean, count = integrate(taken, view, exact=False)
    np.testing.assert_array_equal(count, sums.coverage)
    np.testing.assert_array_equal(mean, sums.mean())


def test_frames_that_are_removed_leave_the_others() -> None:
    taken = frames("u1", 4)
    view = perspective_view(CAMERA, taken[0].pose, 0.0)
    integral, others = (ViewIntegral(view, taken[0].bands, exact=False) for _ in range(2))
    integral.add_all(taken)
    assert integral.add(taken[4]) is False
    integral.remove(taken[1])
    others.add_all([taken[0], *taken[2:]])
    np.testing.assert_array_equal(integral.coverage, others.coverage)
    np.testing.assert_allclose(integral.mean(), others.mean(), atol=1e-3)
    for own in (taken[0], *taken[2:]):
        integral.remove(own)
    assert not integral.coverage.any()
    with pytest.raises(ImagingError, match="vehicle 1 is not part of the integral"):
        integral.remove(taken[1])


@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
@pytest.mark.parametrize("bands", [1, 2, 4, 8, 9])
def test_scores_are_those_of_plain_rx(dtype: str, bands: int) -> None:
    image = picture(dtype, bands)
    np.testing.assert_allclose(rx_scores(image), without_kernels(lambda: rx_scores(image)), rtol=2e-4, atol=2e-4)


@pytest.mark.parametrize("bands", [1, 3, 4])
def test_scores_leave_gaps_out(bands: int) -> None:
    image = picture("f4", bands)
    image[3:17, 100:] = np.nan
    image[60, 60, bands - 1] = -np.inf
    scores = rx_scores(image)
    np.testing.assert_allclose(scores, without_kernels(lambda: rx_scores(image)), rtol=2e-4, atol=2e-4)
    assert np.isnan(scores[60, 60])


@pytest.mark.parametrize("values", [np.nan, 1e30, -np.inf])
def test_images_without_moments_are_left_to_the_plain_way(values: float) -> None:
    image = np.full((20, 20, 2), values, dtype=np.float32)
    np.testing.assert_array_equal(rx_scores(image), without_kernels(lambda: rx_scores(image)))


@pytest.mark.parametrize("bands", [1, 2, 4])
@pytest.mark.parametrize("windows_px", [(33, 65), (3, 9), (101, 201), (1, 399)])
def test_local_scores_are_those_of_box_filters(bands: int, windows_px: tuple[int, int]) -> None:
    image = picture("f4", bands)
    image[50:60, 70] += 300.0
    plain = without_kernels(lambda: local_rx_scores(image, *windows_px))
    np.testing.assert_allclose(local_rx_scores(image, *windows_px), plain, rtol=1e-4, atol=1e-4)
    image[90:, :40] = np.nan
    plain = without_kernels(lambda: local_rx_scores(image, *windows_px))
    np.testing.assert_allclose(local_rx_scores(image, *windows_px), plain, rtol=1e-4, atol=1e-4)


@given(
    arrays(np.float64, (5, 3), elements=st.floats(-100.0, 100.0).map(lambda value: round(value, 1))),
    st.sampled_from([0.01, 1.0]),
)
def test_spans_are_those_of_plain_numpy(half_planes: NDArray[np.float64], scale: float) -> None:
    half_planes[:, :2] *= scale
    spans = covered_spans(half_planes, 12, 15)
    np.testing.assert_array_equal(spans, without_kernels(lambda: covered_spans(half_planes, 12, 15)))


def test_cells_are_counted_by_the_spans_that_hold_them() -> None:
    first = np.random.default_rng(0).integers(0, 40, (4, 30), dtype=np.int32)
    spans = [np.stack((own, own + length), axis=1) for own, length in zip(first, (0, 1, 7, 10), strict=True)]
    columns = np.arange(50)
    expected = sum((columns >= own[:, :1]) & (columns < own[:, 1:]) for own in spans)
    counted = count_spans(spans, 30, 50)
    np.testing.assert_array_equal(counted, expected)
    np.testing.assert_array_equal(without_kernels(lambda: count_spans(spans, 30, 50)), counted)
    np.testing.assert_array_equal(count_spans([], 2, 3), np.zeros((2, 3)))


def test_a_library_of_other_sources_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "sources_checksum", lambda: 17)
    assert library._open(library.FILE) is None


def test_the_kernels_can_be_switched_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(library.SWITCH, "off")
    assert library.loaded.__wrapped__() is None


def test_processors_with_and_without_avx2_give_the_same_digits() -> None:
    compiled = library.loaded()
    common = library._open(library.FILE)
    assert common is not None
    if compiled is None or not common.aos_has_avx2():
        pytest.skip("This processor has no AVX2.")
    image = picture("f4", 4)
    taken = frames("f4", 4)
    view = perspective_view(CAMERA, taken[0].pose, 0.0)

    def work() -> tuple[Pixels, ...]:
        means = (integrate(taken, own, exact=False)[0] for own in (view, hilly_view()))
        return rx_scores(image), local_rx_scores(image), *means

    expected = work()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(library, "loaded", lambda: common)
        for own, other in zip(work(), expected, strict=True):
            np.testing.assert_array_equal(own, other)


@pytest.fixture
def build(tmp_path: Path) -> Callable[[str], tuple[str, set[str]]]:
    """Return a function that builds a package of its own by a compiler, and returns what is told and all its files."""
    copied = tmp_path / "scripts" / SCRIPT.name
    copied.parent.mkdir()
    shutil.copy(SCRIPT, copied)
    package = tmp_path / "aos_gcs" / "imaging" / "native"
    (package / "src").mkdir(parents=True)
    (package / "src" / "one.c").write_text("int one(void) { return 1; }")

    def run(compiler: str) -> tuple[str, set[str]]:
        environment = {"CC": compiler, "PATH": os.defpath}
        result = subprocess.run([sys.executable, copied], env=environment, capture_output=True, text=True, check=True)  # noqa: S603
        return result.stderr, {path.name for path in package.iterdir()}

    return run


def test_a_missing_compiler_is_told_and_changes_nothing(build: Callable[[str], tuple[str, set[str]]]) -> None:
    told, files = build("no-compiler-of-this-name")
    assert "There is no C compiler" in told
    assert files == {"src"}


def test_what_a_compiler_refuses_is_told_and_leaves_nothing_unfinished(
    build: Callable[[str], tuple[str, set[str]]], tmp_path: Path
) -> None:
    compiler = tmp_path / "compiler.sh"
    write_to_target = 'while [ "$1" != -o ]; do shift; done; echo library >"$2"'
    compiler.write_text(f"{write_to_target}; echo 'one.c: no such type' >&2; exit 1")
    told, files = build(f"sh {compiler}")
    assert "cannot be compiled; it works without them" in told
    assert "one.c: no such type" in told
    assert files == {"src"}
    compiler.write_text(write_to_target)
    told, files = build(f"sh {compiler}")
    assert told == ""
    assert files in ({"src", library.FILE}, {"src", library.FILE, library.AVX2_FILE})
