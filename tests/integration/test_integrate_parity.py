"""Virtual views of a recorded flight against those of an independent renderer, out of focus and with a wide view."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.cli.recordings import read_frames, read_poses
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.integral import integrate_view

RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"


@pytest.mark.parametrize("tag", ["plane_z8_defocus", "plane_z18_wide"])
def test_virtual_views_agree_with_an_independent_renderer(tag: str) -> None:
    if not RECORDED.is_dir():
        pytest.skip("the recorded flight F0 is absent: nothing at ../shared/data/F0 beside the repository")
    renders = json.loads((RECORDED / "reference" / "renders.json").read_text())["renders"]
    render: dict[str, Any] = next(r for r in renders if r["tag"] == tag)
    M = np.array(render["virtual_pose_world_to_camera_cv"])
    virtual_pose = Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)
    virtual_camera = CameraModel.from_fov(*render["out_size"], np.radians(render["virtual_fov_deg"]))
    views = read_poses(RECORDED / "poses.json", RECORDED / "images")
    frames = read_frames([views[index] for index in render["view_ids"]], np.radians(render["view_fov_deg"]))
    integral, count = integrate_view(frames, virtual_camera, virtual_pose, render["focal_surface"]["translate_z"])
    with np.load(RECORDED / "reference" / f"{tag}.npz") as reference:
        same = count == reference["count"]
        assert np.count_nonzero(~same) <= 20
        np.testing.assert_array_equal(np.isnan(integral[:, :, 0])[same], np.isnan(reference["integral"])[same])
        error = np.abs(integral[:, :, 0] - reference["integral"])[same & (count > 0)]
        assert error.mean() <= 0.01
        assert error.max() <= 0.15
