"""Virtual views of a recorded flight against those of an independent renderer, on planes and on terrain."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.integral import integrate
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.surfaces.dem_files import read_dem
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalView, perspective_view
from aos_gcs.surveys.images import LazyFrames
from aos_gcs.surveys.poses_file import read_poses

RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"
TAGS = ["plane_z18", "plane_z8_defocus", "plane_z18_wide", "dem_dz-1", "dem_dz-1_nadir"]


@pytest.fixture(scope="module")
def renders() -> dict[str, dict[str, Any]]:
    if not RECORDED.is_dir():
        pytest.skip("the recorded flight F0 is absent: nothing at ../shared/data/F0 beside the repository")
    return {r["tag"]: r for r in json.loads((RECORDED / "reference" / "renders.json").read_text())["renders"]}


@pytest.fixture(scope="module")
def frames(renders: dict[str, dict[str, Any]]) -> list[Frame]:
    survey = read_poses(RECORDED / "poses.json", RECORDED / "images", np.radians(renders["plane_z18"]["view_fov_deg"]))
    return list(LazyFrames(survey.images, survey.bands))


@pytest.fixture(scope="module")
def terrain(renders: dict[str, dict[str, Any]]) -> Terrain:
    assert renders
    return read_dem(RECORDED / "dem_lr.obj.gz")


@pytest.fixture(scope="module", params=TAGS)
def tag(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def view(tag: str, renders: dict[str, dict[str, Any]], terrain: Terrain) -> FocalView:
    render = renders[tag]
    M = np.array(render["virtual_pose_world_to_camera_cv"])
    pose = Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)
    camera = CameraModel.from_fov(*render["out_size"], np.radians(render["virtual_fov_deg"]))
    z_m = render["focal_surface"]["translate_z"]
    return perspective_view(camera, pose, terrain.moved(z_m) if tag.startswith("dem") else z_m)


@pytest.mark.parametrize(("exact", "limits"), [(True, (0.01, 0.15)), (False, (0.05, 1.0))], ids=["exact", "fast"])
def test_virtual_views_agree_with_an_independent_renderer(
    tag: str, view: FocalView, frames: list[Frame], exact: bool, limits: tuple[float, float]
) -> None:
    integral, count = integrate(frames, view, exact=exact)
    with np.load(RECORDED / "reference" / f"{tag}.npz") as reference:
        same = count == reference["count"]
        assert np.count_nonzero(~same) <= 20
        np.testing.assert_array_equal(np.isnan(integral[:, :, 0])[same], np.isnan(reference["integral"])[same])
        error = np.abs(integral[:, :, 0] - reference["integral"])[same & (count > 0)]
        assert error.mean() <= limits[0]
        assert error.max() <= limits[1]
