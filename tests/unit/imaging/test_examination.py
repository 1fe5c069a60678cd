import dataclasses
import math

import numpy as np
import pytest

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import AnomalySource, Detector, Frame
from aos_gcs.imaging.step.analysis import analyse_examined, analyse_step
from aos_gcs.imaging.step.examination import examine, examine_all
from aos_gcs.imaging.step.integration import integrate
from aos_gcs.imaging.step.settings import ImagingSettings

SETTINGS = ImagingSettings(rx_quantile=0.99)
PINHOLE = CameraModel.from_fov(96, 80, math.radians(60.0))
BARREL = dataclasses.replace(
    PINHOLE, distortion=LensDistortion(LensModel.BROWN_CONRADY, (-0.25, 0.08, 0.001, -0.002, 0.0))
)


def frames(camera: CameraModel, gaps: float = 0.0, dtype: type = np.float32) -> list[Frame]:
    rng = np.random.default_rng(5)
    taken = []
    for vehicle_id in range(1, 5):
        image = rng.normal(100.0, 5.0, (80, 96, 2)).astype(dtype)
        image[40:43, 40:44] = 250
        image[rng.random(image.shape[:2]) < gaps, 1] = np.nan if gaps else 0
        pose = nadir_pose([3.0 * vehicle_id, float(vehicle_id), 30.0], 0.3 * vehicle_id)
        taken.append(Frame(vehicle_id, image, ("grey", "thermal"), pose, camera))
    return taken


@pytest.mark.parametrize(
    "taken",
    [
        frames(PINHOLE),
        frames(PINHOLE, dtype=np.uint8),
        frames(BARREL),
        frames(PINHOLE, gaps=0.01),
        frames(BARREL, gaps=0.01),
        [*frames(BARREL)[:2], *frames(PINHOLE, gaps=0.01)[2:3], *frames(PINHOLE)[3:]],
    ],
    ids=["whole", "bytes", "lens", "gaps", "lens and gaps", "mixed"],
)
def test_frames_cover_what_their_integral_has_without_their_images(taken: list[Frame]) -> None:
    analysis = analyse_examined(examine_all(taken, SETTINGS), SETTINGS)
    integral = integrate(taken, analysis.grid)
    # Edges of an image behind a lens, rounded differently, may lie on either side of a cell's centre.
    through_lens = any(frame.camera is BARREL for frame in taken)
    assert (analysis.coverage != integral.coverage).mean() <= (1e-3 if through_lens else 0.0)
    assert integral.coverage.max() == 4


def test_temperatures_and_grey_levels_are_not_mixed_in_one_step() -> None:
    measured, plain = frames(PINHOLE), frames(PINHOLE, dtype=np.uint8)
    analysis = analyse_step([plain[0], *measured[1:]], SETTINGS)
    assert sorted(analysis.skipped) == [1]
    assert "thermal holds grey levels, others have temperatures" in analysis.skipped[1]
    assert analysis.vehicle_ids == (2, 3, 4)
    assert (
        "thermal holds temperatures, others have grey levels"
        in (analyse_step([measured[0], *plain[1:]], SETTINGS).skipped[1])
    )
    grey = [dataclasses.replace(f, bands=("grey", "red")) for f in (measured[0], *plain[1:])]
    assert not analyse_step(grey, SETTINGS).skipped, "colours have no unit"


def test_a_frame_is_examined_before_its_pose_is_known_for_good() -> None:
    reported = frames(PINHOLE)
    corrected = [
        dataclasses.replace(one, pose=nadir_pose(one.pose.position_enu_m + np.array([0.7, 0.2, 0.0])))
        for one in reported
    ]
    examined = [
        dataclasses.replace(one, pose=frame.pose)
        for one, frame in zip(examine_all(reported, SETTINGS), corrected, strict=True)
    ]
    early, late = analyse_examined(examined, SETTINGS), analyse_step(corrected, SETTINGS)
    assert early.blob == late.blob
    assert early.mark_digests == late.mark_digests
    np.testing.assert_array_equal(early.anomaly_count, late.anomaly_count)
    np.testing.assert_array_equal(early.coverage, late.coverage)


def test_what_is_examined_is_small() -> None:
    (one, *_) = examine_all(frames(PINHOLE, gaps=0.01), SETTINGS)
    assert one.marked.nbytes <= 4 * 0.01 * 80 * 96
    assert one.gaps is not None
    assert one.gaps.nbytes == 80 * 96 / 8
    assert examine(frames(PINHOLE)[0], SETTINGS).gaps is None


def test_a_detector_that_lacks_its_band_is_told_of_by_the_analysis() -> None:
    grey = [dataclasses.replace(one, image=one.image[..., :1], bands=("grey",)) for one in frames(PINHOLE)]
    settings = dataclasses.replace(SETTINGS, detector=Detector.THERMAL)
    examined = examine_all(grey, settings)
    with pytest.raises(ImagingError, match="needs a thermal band"):
        analyse_examined(examined, settings)
    # One camera without the band that all others have costs its own frame alone.
    mixed = [*frames(PINHOLE)[:3], grey[3]]
    assert list(analyse_examined(examine_all(mixed, settings), settings).skipped) == [4]


def test_nothing_is_looked_for_in_frames_whose_integral_is_searched() -> None:
    settings = dataclasses.replace(SETTINGS, anomaly_source=AnomalySource.INTEGRAL)
    assert not any(one.marked.size for one in examine_all(frames(PINHOLE), settings))


def test_one_band_is_judged_by_its_surroundings_unless_a_detector_is_chosen() -> None:
    # A warm body on a calm meadow beside a restless forest: to the whole frame it is nothing.
    rng = np.random.default_rng(5)
    image = rng.normal(80.0, 12.0, (200, 200, 1))
    image[:, :100] = rng.normal(80.0, 1.0, (200, 100, 1))
    image[98:102, 48:52] += 20.0
    camera = CameraModel.from_fov(200, 200, math.radians(50.0))
    frame = Frame(1, image.astype(np.float32), ("thermal",), nadir_pose([0.0, 0.0, 30.0]), camera)
    body = 100 * 200 + 50
    assert body in examine(frame, ImagingSettings()).marked
    assert body not in examine(frame, ImagingSettings(detector=Detector.RX)).marked
    assert ImagingSettings().detector_of(("red", "green", "blue", "thermal")) is Detector.RX
