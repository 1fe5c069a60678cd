"""Recordings as they come to ``aos-gcs integrate``: with gaps, copies, other endings and other kinds of values."""

from __future__ import annotations

import csv
import math
import os
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from aos_gcs.surveys.photos import read_photos
from tests.fakes.command_line import exit_status
from tests.fakes.photographs import exif_block, write_photograph, write_temperatures, xmp_packet
from tests.fakes.recorded_flight import Flight
from tests.fakes.survey_flight import CAMERA, FOCAL_35MM, HOT_M, Photographs


@pytest.fixture
def flight(tmp_path: Path) -> Flight:
    return Flight(tmp_path)


def integral_of(flight: Flight, **options: object) -> np.ndarray:
    assert exit_status(flight.arguments(**options)) == 0
    return np.load(flight.out)


def test_images_without_a_file_or_a_pose_are_skipped_on_request(
    flight: Flight, capfd: pytest.CaptureFixture[str]
) -> None:
    (flight.images / "0.png").unlink()
    flight.document["images"][2]["M3x4"][0][3] = float("nan")
    flight.save()
    assert np.isfinite(integral_of(flight, skip_broken=True, view=0)).any()
    errors = capfd.readouterr().err
    assert "2 of 4 images are skipped; 0.png: " in errors
    assert "names the image 0.png, which is not in" in errors


def test_images_that_no_pose_names_are_counted(flight: Flight, capfd: pytest.CaptureFixture[str]) -> None:
    del flight.document["images"][2:]
    flight.save()
    integral_of(flight)
    assert "2 images of the folder have no pose and take no part; the first is 2.png" in capfd.readouterr().err


def test_names_need_not_be_text(flight: Flight, capfd: pytest.CaptureFixture[str]) -> None:
    """Cards of older cameras hold names that are no UTF-8."""
    shutil.copy(flight.images / "0.png", flight.images / os.fsdecode(b"\xe9t\xe9.png"))
    integral_of(flight)
    assert "1 images of the folder have no pose and take no part; the first is \\udce9t" in capfd.readouterr().err


def test_a_pose_far_from_the_others_is_skipped_on_request(flight: Flight, capfd: pytest.CaptureFixture[str]) -> None:
    flight.document["images"][2]["M3x4"][0][3] = 1e6
    flight.save()
    assert np.isfinite(integral_of(flight, skip_broken=True, view=0)).any()
    assert "1 of 4 images are skipped; 2.png: it lies 1,000 km from the middle of" in capfd.readouterr().err


@pytest.mark.parametrize("where", ["images", "file"])
def test_pictures_of_anomalies_replace_nothing(flight: Flight, capfd: pytest.CaptureFixture[str], where: str) -> None:
    (flight.images.parent / "file").touch()
    before = {path.name: path.read_bytes() for path in flight.images.iterdir()}
    folder = flight.images if where == "images" else flight.images.parent / "file" / "pictures"
    blobs = flight.out.with_suffix(".csv")
    assert exit_status(flight.arguments(blobs=blobs, thumbnails=folder, ortho=0.2, view=None, size=None)) == 2
    assert ("it holds the images" if where == "images" else "is a file") in capfd.readouterr().err
    assert {path.name: path.read_bytes() for path in flight.images.iterdir()} == before
    assert not flight.out.exists()


def test_names_may_have_another_ending_than_the_files(flight: Flight, capfd: pytest.CaptureFixture[str]) -> None:
    expected = integral_of(flight)
    for entry in flight.document["images"]:
        entry["imagefile"] = entry["imagefile"].replace(".png", ".tiff")
    flight.save()
    np.testing.assert_array_equal(integral_of(flight), expected)
    assert "have no pose" not in capfd.readouterr().err


def test_three_equal_channels_are_one_band(flight: Flight) -> None:
    expected = integral_of(flight)
    for path in flight.images.iterdir():
        cv2.imwrite(str(path), cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), cv2.COLOR_GRAY2BGR))
    np.testing.assert_array_equal(integral_of(flight), expected)


def test_floating_point_images_keep_their_values(flight: Flight) -> None:
    expected = integral_of(flight)
    for path in flight.images.iterdir():
        celsius = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE).astype(np.float32) / 10.0 - 5.0
        path.write_bytes(cv2.imencode(".tiff", celsius)[1].tobytes())
    np.testing.assert_allclose(integral_of(flight), expected / 10.0 - 5.0, atol=1e-4)


@pytest.mark.parametrize("options", [(), ("--detector", "thermal")], ids=["default", "thermal"])
def test_photographs_with_three_equal_channels_show_what_is_warm(tmp_path: Path, options: tuple[str, ...]) -> None:
    photographs = Photographs(tmp_path, hot=True)
    for name, tags in photographs.tags.items():
        grey = cv2.imread(str(photographs.images / name), cv2.IMREAD_GRAYSCALE)
        photographs.write(name, np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8), tags)
    table = tmp_path / "anomalies.csv"
    assert exit_status(photographs.arguments("--ortho", 0.1, "--blobs", table, *options)) == 0
    (row,) = csv.DictReader(table.read_text().splitlines())
    assert (float(row["x_m"]), float(row["y_m"])) == pytest.approx(HOT_M, abs=0.3)


def test_what_cameras_append_to_a_photograph_does_not_matter(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    for index, extra in enumerate((b"\0" * 100, os.urandom(100_000))):
        with (photographs.images / f"{index}.jpg").open("ab") as file:
            file.write(extra)
    cut = photographs.images / "2.jpg"
    cut.write_bytes(cut.read_bytes()[:-40])
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 0
    assert "1 of 6 images are skipped; 2.jpg: The image" in capfd.readouterr().err


def test_a_copy_of_a_photograph_counts_once(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    shutil.copy(photographs.images / "1.jpg", photographs.images / "1 (copy).jpg")
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 0
    assert "1 of 7 images are skipped; 1.jpg: it is a copy of 1 (copy).jpg" in capfd.readouterr().err


def test_a_photograph_far_from_the_others_is_left_out(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Without a fix some cameras write zeros, or the place of another day."""
    photographs = Photographs(tmp_path)
    tags = photographs.tags["0.jpg"] | {"drone-dji:GpsLatitude": "0.0", "drone-dji:GpsLongitude": "14.0"}
    photographs.write("0.jpg", cv2.imread(str(photographs.images / "0.jpg"), cv2.IMREAD_UNCHANGED), tags)
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 0
    assert re.search(r"1 of 6 images are skipped; 0\.jpg: it lies [45],\d{3} km from", capfd.readouterr().err)
    for index in range(2, 6):
        (photographs.images / f"{index}.jpg").unlink()
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 2
    assert "lie far from each other" in capfd.readouterr().err


def test_photographs_of_several_sensors_are_not_averaged(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    for name in list(photographs.tags)[:3]:
        tags = photographs.tags[name] | {"drone-dji:ImageSource": "InfraredCamera"}
        photographs.write(name, cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), tags)
    for name in list(photographs.tags)[3:]:
        (photographs.images / name).rename(photographs.images / f"DJI_20260101_000{name[0]}_W.JPG")
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 2
    errors = capfd.readouterr().err
    assert "(3 of thermal, such as 0.jpg; 3 of wide, such as DJI_20260101_0003_W.JPG)" in errors
    assert "choose one with --sensor" in errors
    assert not photographs.out.exists()
    assert exit_status(photographs.arguments("--ortho", 0.2, "--sensor", "thermal")) == 0
    expected = "3 of 6 images are skipped; DJI_20260101_0003_W.JPG: it was taken by the sensor wide"
    assert expected in capfd.readouterr().err


def test_photographs_of_different_fields_of_view_are_not_averaged(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    photographs = Photographs(tmp_path)
    image = cv2.imread(str(photographs.images / "4.jpg"), cv2.IMREAD_UNCHANGED)
    packet = xmp_packet(photographs.tags["4.jpg"])
    write_photograph(photographs.images / "4.jpg", image, exif_block(camera={0xA405: 90}), packet)
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 2
    assert "4.jpg has a field of view of 22°, 5.jpg of 63°" in capfd.readouterr().err


@pytest.mark.parametrize("sensor", [None, "WideCamera"])
def test_photographs_of_different_sizes_are_not_averaged(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], sensor: str | None
) -> None:
    """A thermal camera and one of colours with about the same field of view, on an aircraft that names neither."""
    photographs = Photographs(tmp_path)
    for name, tags in list(photographs.tags.items()):
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        image = image if name < "4" else np.asarray(cv2.resize(image, (160, 120)), dtype=np.uint8)
        photographs.write(name, image, tags | ({"drone-dji:ImageSource": sensor} if sensor else {}))
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 2
    errors = capfd.readouterr().err
    assert "(4 of 96 x 72 pixels, such as 0.jpg; 2 of 160 x 120 pixels, such as 4.jpg)" in errors
    assert "Put those of one camera into a folder" in errors
    assert ("or use all with --sensor wide." in errors) == (sensor is not None)
    assert exit_status(photographs.arguments("--ortho", 0.5, "--sensor", "wide")) == (2 if sensor is None else 0)


def test_photographs_of_different_models_are_not_averaged(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)

    def write(name: str, model: str) -> None:
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        exif = exif_block(camera={0xA405: FOCAL_35MM}, model=model)
        write_photograph(photographs.images / name, image, exif, xmp_packet(photographs.tags[name]))

    for name in ("1.jpg", "2.jpg", "3.jpg"):
        write(name, "EVO II")
    # Those without a name are of the one that has one.
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 0
    write("3.jpg", "Duo Pro R\0 ")
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 2
    errors = capfd.readouterr().err
    assert "(2 of the model EVO II, such as 1.jpg; 1 of the model Duo Pro R, such as 3.jpg)" in errors


def test_temperatures_in_geotagged_tiff_files_are_used(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 0
    expected = np.load(photographs.out)
    for name, tags in photographs.tags.items():
        path = photographs.images / name
        celsius = np.asarray(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), dtype=np.float32) / 4.0
        exif = exif_block(camera={0xA405: FOCAL_35MM})
        write_temperatures(path.with_suffix(".tiff"), celsius, exif, xmp_packet(tags))
    # Beside JPEG files they are not looked at: they show the same.
    assert len(read_photos(photographs.images).images) == 6
    for name in photographs.tags:
        (photographs.images / name).unlink()
    assert read_photos(photographs.images).bands == ("grey",)
    assert exit_status(photographs.arguments("--ortho", 0.5, "--detector", "thermal")) == 0
    np.testing.assert_allclose(np.load(photographs.out), expected / 4.0, atol=0.3)
    write_photograph(photographs.images / "0.jpg", np.zeros((72, 96), np.uint8), exif_block())
    capfd.readouterr()
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 2
    assert "None of the 1 photographs" in capfd.readouterr().err


def write_turned(photographs: Photographs, name: str, orientation: int) -> None:
    """Write a photograph with its rows and columns in another order, and the tag that says so."""
    shown = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
    stored = np.ascontiguousarray(np.rot90(shown, {3: 2, 6: 1, 8: 3}[orientation]))
    exif = exif_block(camera={0xA405: FOCAL_35MM}, orientation=orientation)
    write_photograph(photographs.images / name, stored, exif, xmp_packet(photographs.tags[name]))


def test_photographs_with_an_orientation_tag_are_turned(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    assert exit_status(photographs.arguments("--ortho", 0.25)) == 0
    expected = np.load(photographs.out)
    capfd.readouterr()
    for name, orientation in (("1.jpg", 3), ("2.jpg", 6), ("4.jpg", 8)):
        write_turned(photographs, name, orientation)
    assert exit_status(photographs.arguments("--ortho", 0.25)) == 0
    assert "3 photographs are turned by their Orientation tag; the first is 1.jpg" in capfd.readouterr().err
    integral = np.load(photographs.out)
    assert integral.shape == expected.shape
    # Pictures are compressed once more.
    assert np.nanmax(np.abs(integral - expected)) < 3.0


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_tiff_photographs_with_an_orientation_tag_are_turned_once(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], dtype: type
) -> None:
    """OpenCV 5 turns the pixels of TIFF files by the tag, whatever it is asked for."""
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    assert exit_status(photographs.arguments("--ortho", 0.25)) == 0
    expected = np.load(photographs.out)
    for index, orientation in enumerate((3, 6, 8, 1, 6, 3)):
        shown = cv2.imread(str(photographs.images / f"{index}.jpg"), cv2.IMREAD_UNCHANGED)
        stored = np.ascontiguousarray(np.rot90(np.asarray(shown), {1: 0, 3: 2, 6: 1, 8: 3}[orientation]), dtype=dtype)
        exif = exif_block(camera={0xA405: FOCAL_35MM}, orientation=orientation)
        exif[700] = xmp_packet(photographs.tags[f"{index}.jpg"])
        Image.fromarray(stored).save(photographs.images / f"{index}.tif", "TIFF", exif=exif)
        (photographs.images / f"{index}.jpg").unlink()
    capfd.readouterr()
    assert exit_status(photographs.arguments("--ortho", 0.25)) == 0
    assert "5 photographs are turned by their Orientation tag; the first is 0.tif" in capfd.readouterr().err
    np.testing.assert_allclose(np.load(photographs.out), expected, atol=0.001)


def test_photographs_in_folders_within_the_folder_are_used(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 0
    expected = np.load(photographs.out)
    capfd.readouterr()
    for folder, names in (("100MEDIA", ("0.jpg", "1.jpg")), ("101MEDIA/more", ("2.jpg", "3.jpg")), (".trash", ())):
        (photographs.images / folder).mkdir(parents=True)
        for name in names:
            (photographs.images / name).rename(photographs.images / folder / name)
    shutil.copy(photographs.images / "4.jpg", photographs.images / ".trash" / "9.jpg")
    shutil.copy(photographs.images / "4.jpg", photographs.images / "101MEDIA" / "4.jpg")
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 0
    np.testing.assert_allclose(np.load(photographs.out), expected, atol=1e-3)
    assert "1 of 7 images are skipped; 4.jpg: it is a copy of 4.jpg" in capfd.readouterr().err


def test_rtk_accuracies_are_reported(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    for index in range(6):
        name = f"{index}.jpg"
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        stds = {"drone-dji:RtkStdLon": 0.011, "drone-dji:RtkStdLat": 0.013, "drone-dji:RtkStdHgt": 0.025}
        flag = {"drone-dji:RtkFlag": 34 if index == 2 else 50}
        photographs.write(name, image, photographs.tags[name] | stds | flag)
    survey = read_photos(photographs.images)
    assert survey.images[0].position_sigma_m == (0.011, 0.013, 0.025)
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 0
    errors = capfd.readouterr().err
    assert "RTK positions of 6 of 6 photographs: median standard deviation 0.012 m horizontally, 0.025 m" in errors
    assert "1 of 6 photographs were taken without a fixed RTK solution; the first is 2.jpg" in errors


@pytest.mark.parametrize(("beside_deg", "is_remarked"), [(3.0, False), (-12.0, True), (90.0, False)])
def test_a_gimbal_that_does_not_follow_its_aircraft_is_reported(
    tmp_path: Path, beside_deg: float, is_remarked: bool
) -> None:
    """The gimbal's yaw was 12° off on a real flight, and that of the aircraft was the direction of flight."""
    photographs = Photographs(tmp_path)
    for name, tags in photographs.tags.items():
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        aircraft_deg = tags["drone-dji:GimbalYawDegree"] - beside_deg
        photographs.write(name, image, {**tags, "drone-dji:FlightYawDegree": aircraft_deg})
    remarks = read_photos(photographs.images).remarks
    assert len(remarks) == is_remarked
    assert all(remark.startswith("the gimbal's yaw is -12° from the aircraft's") for remark in remarks)


def test_photographs_without_a_focal_length_need_the_field_of_view(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    photographs = Photographs(tmp_path)
    for name, tags in photographs.tags.items():
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        write_photograph(photographs.images / name, image, exif_block(), xmp_packet(tags))
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 2
    errors = capfd.readouterr().err
    assert "0.jpg: it has no CalibratedFocalLength of its own" in errors
    assert "give the field of view (--fov) or a camera file (--camera)" in errors
    fov_deg = math.degrees(CAMERA.horizontal_fov_rad)
    assert exit_status(photographs.arguments("--ortho", 0.5, "--fov", fov_deg)) == 0


def test_photographs_saved_by_other_software_are_reported(tmp_path: Path) -> None:
    """A viewer had turned six of 18 pictures of a Phantom 3, and left their tags as they were."""
    photographs = Photographs(tmp_path)
    for index in range(6):
        name, program = f"{index}.jpg", "Photo Viewer 10" if index in {2, 3} else "v01.23.4920"
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        exif = exif_block(camera={0xA405: FOCAL_35MM}, software=program)
        write_photograph(photographs.images / name, image, exif, xmp_packet(photographs.tags[name]))
    (remark,) = read_photos(photographs.images).remarks
    assert remark.startswith(
        "2 of 6 photographs were saved by other software than the rest, such as 2.jpg by Photo View"
    )


def test_a_poses_file_may_begin_with_the_mark_of_its_encoding(flight: Flight) -> None:
    """Editors and shells of Windows write one."""
    flight.poses.write_bytes(b"\xef\xbb\xbf" + flight.poses.read_bytes())
    assert exit_status(flight.arguments()) == 0
