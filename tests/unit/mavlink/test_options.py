from __future__ import annotations

from pathlib import Path

import pytest

from aos_drivers.links.recorder import TlogRecorder
from aos_drivers.options import DriverOptions
from aos_gcs.errors import ConfigurationError
from tests.fakes.mavlink_vehicle import FakeVehicle


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"position_rate": 5}, "position_rate"),
        ({"position_hz": 0}, "position_hz"),
        ({"position_hz": True}, "position_hz"),
        ({"image_hosts": "10.0.0.1"}, "image_hosts"),
        ({"max_image_mib": -1}, "max_image_mib"),
    ],
)
def test_bad_options_are_named(options: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        DriverOptions.parse(options)


def test_options_have_defaults_and_are_taken_over() -> None:
    assert DriverOptions.parse({}) == DriverOptions()
    options = DriverOptions.parse({"position_hz": 10, "image_hosts": ["cam1"], "max_image_mib": 2})
    assert (options.position_hz, options.image_hosts, options.image_limits.max_bytes) == (10.0, ("cam1",), 2**21)


def test_a_recording_is_a_timestamp_and_a_packet_each_and_goes_on_where_it_ended(tmp_path: Path) -> None:
    packet = FakeVehicle().heartbeat()
    for utc_s in (1.5, 2.0):
        recorder = TlogRecorder(tmp_path / "log" / "a.tlog", pytest.fail)
        recorder.write(packet, utc_s)
        recorder.close()
    data = (tmp_path / "log" / "a.tlog").read_bytes()
    assert data == (1_500_000).to_bytes(8, "big") + packet + (2_000_000).to_bytes(8, "big") + packet


def test_packets_that_were_read_together_are_recorded_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_drivers.links.recorder._BUFFER_BYTES", 40)
    recorder = TlogRecorder(tmp_path / "a.tlog", pytest.fail)
    with recorder._lock:  # the writer waits for it
        recorder._buffer += b"first"
    recorder.write_all([b"one", b"a packet that is too long for the rest", b"two"], 1.5)
    recorder.close()
    stamp = (1_500_000).to_bytes(8, "big")
    assert (tmp_path / "a.tlog").read_bytes() == b"first" + stamp + b"one" + stamp + b"two"
    assert recorder.dropped == 1


def test_a_full_disk_ends_the_recording_with_one_report() -> None:
    errors: list[OSError] = []
    recorder = TlogRecorder(Path("/dev/full"), errors.append)
    recorder.write(b"x", 0.0)
    recorder.close()
    assert len(errors) == 1


def test_a_full_buffer_drops_the_newest_and_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aos_drivers.links.recorder._BUFFER_BYTES", 30)
    recorder = TlogRecorder(tmp_path / "a.tlog", pytest.fail)
    with recorder._lock:
        recorder._buffer += bytes(20)
    recorder.write(bytes(20), 0.0)
    recorder.close()
    assert recorder.dropped == 1
