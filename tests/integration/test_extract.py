"""``aos-gcs extract``: frames and poses of a video with telemetry in its subtitles."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import intersect_plane
from tests.fakes import recorded_video as flight
from tests.fakes.command_line import exit_status

av = pytest.importorskip("av", reason="needs the extra video")

SECONDS = 6.0


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A thermal video beside its subtitles."""
    path = tmp_path_factory.mktemp("video") / "DJI_0001_T.MP4"
    flight.write_video(path, av, SECONDS)
    flight.write_subtitles(path.with_suffix(".SRT"), SECONDS)
    return path


@dataclass(frozen=True, slots=True, eq=False)
class Extracted:
    """What the command has written, in the world of the true flight."""

    folder: Path

    def poses(self) -> dict[float, Pose]:
        document = json.loads((self.folder / "poses.json").read_text())
        shift_m = LocalFrame(flight.ORIGIN).to_enu(GeodeticPosition(*document["origin"]))
        poses = {}
        for image in document["images"]:
            assert (self.folder / image["imagefile"]).is_file()
            M = np.array(image["M3x4"])
            poses[image["time_s"]] = Pose(-M[:, :3].T @ M[:, 3] + shift_m, M[:, :3].T)
        return poses

    def images(self) -> list[NDArray[np.uint8]]:
        return [
            np.asarray(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
            for path in sorted(self.folder.iterdir())
            if path.suffix != ".json"
        ]


def extract(video: Path, out: Path, *options: object) -> Extracted:
    assert exit_status(["extract", str(video), "--out", str(out), *map(str, options)]) == 0
    return Extracted(out)


def refusal(video: Path, out: Path, capsys: pytest.CaptureFixture[str], *options: object) -> str:
    """Return what a refused command says; it must leave nothing behind."""
    before = set(out.parent.iterdir())
    assert exit_status(["extract", str(video), "--out", str(out), *map(str, options)]) == 2
    assert set(out.parent.iterdir()) == before
    return capsys.readouterr().err


def angle_deg(one: Pose, other: Pose) -> float:
    cosine = (np.trace(one.R_cam2enu.T @ other.R_cam2enu) - 1.0) / 2.0
    return math.degrees(math.acos(min(1.0, float(cosine))))


def test_frames_of_a_thermal_video_have_one_band_and_the_poses_of_their_times(video: Path, tmp_path: Path) -> None:
    extracted = extract(video, tmp_path / "frames")
    poses = extracted.poses()
    errors_m = [
        np.linalg.norm(pose.position_enu_m - flight.true_pose(at_s).position_enu_m) for at_s, pose in poses.items()
    ]
    # Subtitles round positions to a millionth of a degree, 0.11 m.
    assert max(errors_m) < 0.15
    assert max(angle_deg(pose, flight.true_pose(at_s)) for at_s, pose in poses.items()) < 0.1
    images = extracted.images()
    assert len(images) == len(poses) == pytest.approx(SECONDS * flight.SPEED_MPS, abs=1)
    assert {image.shape for image in images} == {(flight.HEIGHT, flight.WIDTH)}


def test_nothing_but_the_result_is_said(video: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """OpenCV's library would say of every image that an option of another format is ignored."""
    assert exit_status(["extract", str(video), "--out", str(tmp_path / "frames")]) == 0
    captured = capfd.readouterr()
    assert captured.err == ""
    assert captured.out.count("\n") == 1


def test_their_integral_shows_the_ground(video: Path, tmp_path: Path) -> None:
    extracted = extract(video, tmp_path / "frames")
    poses, integral = tmp_path / "frames" / "poses.json", tmp_path / "integral.npy"
    options = ["--poses", poses, "--fov", flight.FOV_DEG, "--plane-z", 0, "--view", 5, "--size", 64, "--out", integral]
    assert exit_status(["integrate", str(extracted.folder), *map(str, options)]) == 0
    pose = list(extracted.poses().values())[5]
    camera = CameraModel.from_fov(64, 64, math.radians(flight.FOV_DEG))
    u, v = np.meshgrid(np.arange(64), np.arange(64))
    points_m = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1).astype(np.float64), camera, pose, 0.0)
    values = np.load(integral).reshape(64, 64)
    seen = np.isfinite(values)
    assert seen.mean() > 0.6
    expected = flight.grey_at(points_m).reshape(64, 64)
    assert np.abs(values - expected)[seen].mean() < 6.0


def test_frames_are_chosen_by_time_within_a_part(video: Path, tmp_path: Path) -> None:
    extracted = extract(video, tmp_path / "frames", "--every", 0.5, "--from", 1.0, "--to", 3.0)
    assert list(extracted.poses()) == pytest.approx([1.0, 1.5, 2.0, 2.5, 3.0])


def test_subtitles_may_be_a_track_of_the_video(tmp_path: Path) -> None:
    path = tmp_path / "with_track.mp4"
    flight.write_video(path, av, 2.0, colour=True, subtitles=True)
    extracted = extract(path, tmp_path / "frames", "--every", 0.4)
    for at_s, pose in extracted.poses().items():
        assert np.linalg.norm(pose.position_enu_m - flight.true_pose(at_s).position_enu_m) < 0.2
    images = extracted.images()
    assert {path.suffix for path in extracted.folder.iterdir()} == {".jpg", ".json"}
    assert {image.shape for image in images} == {(flight.HEIGHT, flight.WIDTH, 3)}


def test_an_attitude_can_be_told_by_the_course(video: Path, tmp_path: Path) -> None:
    subtitles = tmp_path / "no_gimbal.srt"
    flight.write_subtitles(subtitles, SECONDS, gimbal=False)
    extracted = extract(video, tmp_path / "frames", "--subtitles", subtitles, "--attitude", "course,-90")
    for pose in extracted.poses().values():
        up_edge = -pose.R_cam2enu[:, 1]
        assert math.degrees(math.atan2(up_edge[0], up_edge[1])) == pytest.approx(45.0, abs=12.0)
        assert pose.R_cam2enu[2, 2] == pytest.approx(-1.0)


def test_frames_of_another_zoom_and_without_telemetry_are_left_out(
    video: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    subtitles = tmp_path / "short.srt"
    cues = [flight.cue(i, i / 10, flight.telemetry(i / 10, zoom=1.0 if i < 10 else 2.0)) for i in range(30)]
    subtitles.write_text("".join(cues))
    extracted = extract(video, tmp_path / "frames", "--subtitles", subtitles, "--every", 0.1)
    assert max(extracted.poses()) == pytest.approx(0.9)
    err = capsys.readouterr().err
    assert "were taken with another digital zoom" in err
    assert "have no telemetry near their time" in err


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--spacing", 1, "--every", 1), "exclude each other"),
        (("--every", 0), "--every must be a positive number"),
        (("--from", 3, "--to", 2), "must name a part of the video"),
        (("--from", 50), "No frame"),
        (("--attitude", "north,-90"), "--attitude needs YAW,PITCH[,ROLL]"),
        (("--attitude", "1e300,-90"), "--attitude needs YAW,PITCH[,ROLL]"),
        (("--attitude", "0,-90,1e300"), "--attitude needs YAW,PITCH[,ROLL]"),
        (("--ground", "nan"), "--ground must be an altitude"),
        (("--ground", "1e300"), "--ground must be an altitude"),
        (("--subtitles", "absent.srt"), "cannot be read"),
    ],
)
def test_wrong_options_are_refused(
    video: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[object, ...], reason: str
) -> None:
    assert reason in refusal(video, tmp_path / "frames", capsys, *options)


def test_files_that_cannot_be_used_are_refused(video: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    subtitles = video.with_suffix(".SRT")
    assert "does not exist" in refusal(tmp_path / "absent.mp4", tmp_path / "f", capsys, "--subtitles", subtitles)
    text = tmp_path / "text.mp4"
    text.write_text("no video")
    assert "is not a readable MP4, MOV or MKV" in refusal(text, tmp_path / "f", capsys, "--subtitles", subtitles)
    playlist = tmp_path / "list.mp4"
    playlist.write_text(f"#EXTM3U\n#EXTINF:1,\nfile://{video}\n")
    assert "is not a readable MP4, MOV or MKV" in refusal(playlist, tmp_path / "f", capsys, "--subtitles", subtitles)
    alone = tmp_path / "alone.mp4"
    alone.write_bytes(video.read_bytes())
    assert "has neither a subtitle file beside it" in refusal(alone, tmp_path / "f", capsys)
    for name, values, reason in (
        ("no_fix", "[latitude: 0.000000] [longitude: 0.000000] [rel_alt: 1.0]", "has a position"),
        ("no_height", "[latitude: 47.5] [longitude: 14.2] [gb_yaw: 0 gb_pitch: -90 gb_roll: 0]", "no rel_alt"),
        ("no_gimbal", "[latitude: 47.5] [longitude: 14.2] [rel_alt: 1.0]", "no angles of the gimbal"),
    ):
        bad = tmp_path / f"{name}.srt"
        bad.write_text(flight.cue(1, 0.0, values))
        assert reason in refusal(video, tmp_path / "f", capsys, "--subtitles", bad)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    assert "exists already" in refusal(video, tmp_path / "full", capsys)


def test_folders_are_kept_where_nothing_is_extracted(
    video: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    assert "No frame" in refusal(video, empty, capsys, "--from", 50)
    assert "it is not a file" in refusal(tmp_path, empty, capsys)
    monkeypatch.chdir(empty)
    assert "exists already" in refusal(video, Path(), capsys)


def test_what_can_be_read_of_a_video_that_was_cut_off_is_kept(video: Path, tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mkv", tmp_path / "cut.mkv"
    flight.write_video(whole, av, 3.0)
    data = whole.read_bytes()
    cut.write_bytes(data[: len(data) * 2 // 3])
    extracted = extract(cut, tmp_path / "frames", "--subtitles", video.with_suffix(".SRT"), "--every", 0.1)
    assert len(extracted.images()) == len(extracted.poses())
    assert 5 < len(extracted.images()) < 30
