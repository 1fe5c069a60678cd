"""Telemetry of videos: subtitles of several aircraft, and poses between their samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.surveys.video.subtitles import Attitude, CueTelemetry, read_subtitle_file, samples_of
from aos_gcs.surveys.video.track import FlightTrack

M30T = (
    "[focal_len: 40.00] [dzoom_ratio: 2.00], [latitude: -37.920295] [longitude: 176.456417] [rel_alt: 62.370 abs_alt: "
    "227.373] [gb_yaw: -142.5 gb_pitch: -28.7 gb_roll: 0.1] </font>"
)
MAVIC_2 = (
    "2019-09-27 10:28:08,438,904\n[iso : 110] [shutter : 1/1250.0] [fnum : 280] [ev : 0] [latitude : -35.080155] "
    "[longtitude : -60.286702] [altitude: 74.725998] </font>"
)


def sample(time_s: float, east_deg: float = 0.0, yaw_deg: float = 0.0, up_m: float = 30.0) -> CueTelemetry:
    return CueTelemetry(time_s, 47.0, 14.0 + east_deg, up_m, 500.0 + up_m, (yaw_deg, -90.0, 0.0), 1.0)


P4_RTK = (
    "F/5.6, SS 400, ISO 100, EV 0, GPS (-58.851745, -34.237922, 15), HOME (-58.847509, -34.232707, -57.98m), D "
    "698.70m, H 85.80m, H.S 0.00m/s, V.S 0.00m/s, F.PRY (2.7°, -7.0°, 110.1°), G.PRY (-24.4°, 0.0°, 110.4°)"
)


def test_a_list_of_values_is_read() -> None:
    (sample,) = samples_of(iter([(0.0, P4_RTK)]), "file")
    assert (sample.latitude_deg, sample.longitude_deg) == (-34.237922, -58.851745)
    assert (sample.relative_altitude_m, sample.altitude_amsl_m) == (85.8, None)
    assert sample.gimbal_deg == (110.4, -24.4, 0.0)
    with pytest.raises(InputDataError, match=r"or 'GPS \(...\)' to five decimals or more"):
        samples_of(iter([(0.0, "F/3.2, SS 160, GPS (8.2090, 47.4692, 18), D 49.21m, H 45.60m")]), "file")


def test_values_of_enterprise_aircraft() -> None:
    assert samples_of(iter([(1.5, M30T)]), "file") == [
        CueTelemetry(1.5, -37.920295, 176.456417, 62.37, 227.373, (-142.5, -28.7, 0.1), 2.0)
    ]


def test_values_of_older_aircraft() -> None:
    assert samples_of(iter([(0.0, MAVIC_2)]), "file") == [
        CueTelemetry(0.0, -35.080155, -60.286702, None, 74.725998, None, 1.0)
    ]


def test_cues_without_a_place_are_left_out() -> None:
    cues = [(0.0, "[latitude: 0.0] [longitude: 0.0]"), (1.0, "[iso: 100]"), (2.0, M30T), (3.0, "[latitude: 95.0]")]
    assert [known.time_s for known in samples_of(iter(cues), "file")] == [2.0]
    with pytest.raises(InputDataError, match="None of the 1 cues of file has a position"):
        samples_of(iter(cues[:1]), "file")


def test_decimal_commas_are_not_cut_off() -> None:
    """What stands before the comma would be a place up to a hundred kilometres away."""
    with pytest.raises(InputDataError, match="None of the 1 cues"):
        samples_of(iter([(0.0, "[latitude: 47,512345] [longitude: 14,212345]")]), "file")


def test_numbers_beyond_all_aircraft_are_not_recorded() -> None:
    endless = "9" * 400
    cue = (
        f"[latitude: 47.5] [longitude: 14.2] [rel_alt: {endless} abs_alt: 999999.0] [gb_yaw: {endless} gb_pitch: -90.0 "
    )
    (known,) = samples_of(iter([(0.0, cue + "gb_roll: 0.0]")]), "file")
    assert (known.relative_altitude_m, known.altitude_amsl_m, known.gimbal_deg) == (None, None, None)


def test_subtitles_of_several_videos_are_refused() -> None:
    times_s = (0.0, 60.0, 0.5, 61.0)
    with pytest.raises(InputDataError, match=r"go back from 60\.0 s to 0\.5 s at cue 3"):
        samples_of(iter([(time_s, M30T) for time_s in times_s]), "file")


@pytest.mark.parametrize("parting", ["\n\n", "\n", "\r\n\r\n", "\r\r"], ids=["blank", "none", "windows", "returns"])
def test_cues_are_told_apart_by_their_times(tmp_path: Path, parting: str) -> None:
    line = parting[: len(parting) // 2] or parting
    path = tmp_path / "video.srt"
    cues = [f"{i + 1}{line}00:00:0{i},500 --> 00:00:0{i + 1},500{line}{M30T}" for i in range(3)]
    path.write_bytes(parting.join(cues).encode())
    assert [known.time_s for known in read_subtitle_file(path)] == [0.5, 1.5, 2.5]


@pytest.mark.parametrize(
    "text",
    ["1" * 2_000_000, "a" * 2_000_000, f"1\n{'9' * 5000}:00:00,000 --> 00:00:01,000\n{M30T}"],
    ids=["digits", "letters", "hours"],
)
def test_texts_that_are_no_cues_are_refused_in_linear_time(tmp_path: Path, text: str) -> None:
    path = tmp_path / "video.srt"
    path.write_text(f"1\n00:00:00,000 --> 00:00:01,000\n{text}")
    if M30T in text:
        path.write_text(text)
    with pytest.raises(InputDataError, match="has a position"):
        read_subtitle_file(path)


@settings(max_examples=50)
@given(st.text(alphabet="[]: -.0123456789latiudeongr_", max_size=120))
def test_any_text_gives_samples_or_an_error(text: str) -> None:
    try:
        samples = samples_of(iter([(0.0, text)]), "file")
    except InputDataError:
        return
    assert all(math.isfinite(known.latitude_deg + known.longitude_deg) for known in samples)


def test_positions_that_come_more_slowly_than_cues_are_no_stair() -> None:
    """A receiver tells every fifth cue a new place; between them the aircraft flies on."""
    step_deg = 1e-5
    track = FlightTrack([sample(i / 10, (i // 5) * step_deg) for i in range(31)])
    east_m = [track.position_m(i / 10)[0] for i in range(26)]
    assert np.diff(east_m) == pytest.approx(np.full(25, east_m[-1] / 25), rel=1e-3)


@pytest.mark.parametrize("wrong", [range(3), range(10, 12), range(37, 40), (5,), (0, 20, 39)])
def test_positions_that_no_aircraft_reaches_are_left_out(wrong: Sequence[int]) -> None:
    """A receiver's errors would place the origin, or a frame, kilometres away."""
    flight = [sample(i / 10, i * 1e-5) for i in range(40)]
    track = FlightTrack([sample(i / 10, 0.6) if i in wrong else flight[i] for i in range(40)])
    assert track.jumps == len(wrong)
    assert track.origin.longitude_deg == pytest.approx(14.0, abs=4e-5)
    ways_m = [track.position_m(i / 10) for i in range(40)]
    assert np.abs(np.diff(ways_m, axis=0)).max() < 5.0


def test_positions_that_come_once_a_second_are_no_jumps() -> None:
    """Flight at 25 m/s, with cues of every frame that repeat the positions, and a gap of ten seconds."""
    metre_deg = 1.0 / 76_000.0
    seconds = [*range(20), *range(30, 50)]
    samples = [sample(s + i / 30, 25.0 * s * metre_deg) for s in seconds for i in range(30)]
    assert FlightTrack(samples).jumps == 0


def test_a_hover_is_no_slow_flight() -> None:
    track = FlightTrack([*(sample(i / 10) for i in range(50)), sample(5.0, 1e-5)])
    assert track.position_m(4.8)[0] == pytest.approx(0.0, abs=1e-6)
    assert track.position_m(5.0)[0] == pytest.approx(0.76, abs=0.01)


def test_turns_take_the_short_way() -> None:
    track = FlightTrack([sample(0.0, 0.0, 179.0), sample(1.0, 0.0, -179.0)])
    up_edge = -track.pose(0.5).R_cam2enu[:, 1]
    assert up_edge == pytest.approx([0.0, -1.0, 0.0], abs=1e-6)


def test_heights_are_above_the_takeoff_or_above_a_told_ground() -> None:
    samples = [sample(0.0), sample(1.0)]
    assert FlightTrack(samples).position_m(0.0)[2] == pytest.approx(30.0)
    assert FlightTrack(samples).origin.altitude_amsl_m == pytest.approx(500.0)
    told = FlightTrack(samples, ground_amsl_m=510.0)
    assert told.position_m(0.0)[2] == pytest.approx(20.0)
    assert told.origin.altitude_amsl_m == pytest.approx(510.0)


def test_telemetry_is_known_near_its_samples_only() -> None:
    track = FlightTrack([sample(10.0), sample(11.0)])
    assert [track.is_known(time_s) for time_s in (8.0, 9.0, 10.4, 12.0, 13.0)] == [False, True, True, True, False]


def test_a_course_needs_a_movement() -> None:
    track = FlightTrack([sample(0.0), sample(3.0)], attitude=Attitude(None, -90.0))
    with pytest.raises(InputDataError, match="did not move"):
        track.pose(1.0)
    moving = FlightTrack([sample(0.0), sample(3.0, 1e-4)], attitude=Attitude(None, -90.0))
    assert -moving.pose(1.5).R_cam2enu[:, 1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)


def test_one_sample_is_a_place() -> None:
    track = FlightTrack([sample(2.0, yaw_deg=90.0)])
    assert track.pose(2.4).position_enu_m == pytest.approx([0.0, 0.0, 30.0], abs=1e-6)
    assert -track.pose(2.4).R_cam2enu[:, 1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
