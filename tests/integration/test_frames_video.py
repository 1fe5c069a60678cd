"""Video as the frames of a vehicle: RTP with RTCP, MPEG-TS without times, and RTSP, all served by PyAV."""

from __future__ import annotations

import asyncio
import io
import math
import socket
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, asynccontextmanager, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError
from aos_drivers.frames.settings import CameraSettings, ImagePlace, SourceKind
from aos_drivers.frames.stream.clock import SENDER_SIGMA_S, FrameTime
from aos_drivers.frames.stream.receiver import KEPT_FRAMES, StreamFrame, VideoReceiver
from aos_gcs.clock import LoopClock
from aos_gcs.equal_bands import COLOURS, GREY
from tests.fakes.program import unused_port
from tests.fakes.shutter_vehicle import PITCH_DEG, NoDownloads, ShutterVehicle, deadline_s, open_camera
from tests.timing import scaled_s

av = pytest.importorskip("av", reason="needs the extra video")

WIDTH, HEIGHT, RATE_HZ = 64, 48, 20
bench = partial(open_camera, fetcher=NoDownloads())
FOV_RAD = 0.9


@contextmanager
def sending(send: Callable[[threading.Event], None]) -> Iterator[None]:
    """Call ``send`` again and again, in a thread, until its event is set."""
    end = threading.Event()

    def run() -> None:
        while not end.is_set():
            try:
                send(end)
            except (av.FFmpegError, OSError):
                end.wait(0.05)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join(5.0)


def rtp(port: int) -> Callable[[threading.Event], None]:
    return lambda end: encode(f"rtp://127.0.0.1:{port}", "rtp", end)


def mpeg_ts(port: int) -> Callable[[threading.Event], None]:
    """Serve one client at a time."""

    def send(end: threading.Event) -> None:
        with socket.create_server(("127.0.0.1", port)) as server:
            server.settimeout(0.1)
            connection, _ = server.accept()
            with connection, connection.makefile("wb") as file:
                encode(file, "mpegts", end)

    return send


def encode(target: Any, kind: str, end: threading.Event, frames: int = 10_000) -> None:
    """Send H.264 in real time, whose red grows by 5 per frame; what the machine delays is caught up with."""
    began_s = time.monotonic()
    with av.open(target, "w", format=kind) as output:
        stream: Any = output.add_stream("libx264", rate=RATE_HZ, options={"preset": "ultrafast", "tune": "zerolatency"})
        stream.width, stream.height, stream.pix_fmt, stream.gop_size = WIDTH, HEIGHT, "yuv420p", 5
        for number in range(frames):
            pixels = np.full((HEIGHT, WIDTH, 3), (number * 5 % 256, 80, 160), np.uint8)
            picture = av.VideoFrame.from_ndarray(pixels, "rgb24")
            for packet in stream.encode(picture):
                output.mux(packet)
            if end.wait(max(0.0, began_s + (number + 1) / RATE_HZ - time.monotonic())):
                return


def session_description(port: int) -> str:
    return (
        "v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=x\r\nc=IN IP4 127.0.0.1\r\nt=0 0\r\n"
        f"m=video {port} RTP/AVP 96\r\na=rtpmap:96 H264/90000\r\na=fmtp:96 packetization-mode=1\r\n"
    )


def description_file(folder: Path, port: int) -> str:
    path = folder / "stream.sdp"
    path.write_text(session_description(port), encoding="utf-8")
    return str(path)


@asynccontextmanager
async def rtsp_server() -> AsyncIterator[tuple[str, list[str]]]:
    """Answer as an RTSP server does (RFC 2326), and send RTP to the port that is set up; yields address and methods."""
    methods: list[str] = []
    with ExitStack() as senders:

        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            while request := await read_request(reader):
                methods.append(request[0].split()[0])
                headers = dict(line.split(": ", 1) for line in request[1:])
                lines, body = [f"CSeq: {headers['CSeq']}", "Session: 1"], ""
                if methods[-1] == "DESCRIBE":
                    body = session_description(0) + "a=control:track0\r\n"
                    lines += ["Content-Type: application/sdp", f"Content-Length: {len(body)}"]
                elif methods[-1] == "SETUP":
                    port = int(headers["Transport"].split("client_port=")[1].split("-")[0])
                    lines.append(f"Transport: RTP/AVP/UDP;unicast;client_port={port}-{port + 1}")
                    senders.enter_context(sending(rtp(port)))
                writer.write("\r\n".join(["RTSP/1.0 200 OK", *lines, "", body]).encode())
            writer.close()

        server = await asyncio.start_server(serve, "127.0.0.1", 0)
        async with server:
            yield f"rtsp://127.0.0.1:{server.sockets[0].getsockname()[1]}/main", methods


async def read_request(reader: asyncio.StreamReader) -> list[str]:
    lines = []
    while line := (await reader.readline()).decode().strip():
        lines.append(line)
    return lines


def settings_of(address: str, **changes: object) -> CameraSettings:
    values = {"source": SourceKind.VIDEO, "place": ImagePlace(url=address), "fov_rad": FOV_RAD}
    return CameraSettings(**(values | changes))  # type: ignore[arg-type]


async def test_rtp_gives_frames_with_the_senders_times_and_interpolated_poses(tmp_path: Path) -> None:
    port = unused_port()
    settings = settings_of(description_file(tmp_path, port))
    with sending(rtp(port)):
        async with bench(ShutterVehicle(lambda _: None), settings) as network:
            first = await network.vehicle().capture(deadline_s(network, scaled_s(20.0)))
            second, captures = first, 1
            # The sender reports its time every few frames; it is used while frames arrive in time.
            while captures < 2 or second.time_sigma_s != SENDER_SIGMA_S:
                asked_at_utc_s = network.clock.utc_s()
                second, captures = await network.vehicle().capture(deadline_s(network, scaled_s(20.0))), captures + 1
            got_at_utc_s = network.clock.utc_s()
            state = network.vehicle().state.camera
    assert first.image.shape == (HEIGHT, WIDTH, 3)
    assert first.bands == ("red", "green", "blue")
    assert second.image_index > first.image_index
    assert asked_at_utc_s <= second.utc_s <= got_at_utc_s + SENDER_SIGMA_S
    tilt = math.radians(PITCH_DEG)
    assert second.R_cam2enu[:, 2] == pytest.approx([math.sin(tilt), 0.0, -math.cos(tilt)], abs=1e-4)
    assert state is not None
    assert (state.source, state.frames) == ("video", captures)


@pytest.mark.parametrize(
    ("codec", "pixel_format"), [("libx264", "yuv420p"), ("mjpeg", "yuvj420p"), ("mpeg4", "yuv420p")]
)
@pytest.mark.parametrize("has_colours", [False, True])
def test_a_thermal_cameras_stream_is_grey_whatever_its_pixel_format(
    codec: str, pixel_format: str, has_colours: bool
) -> None:
    film, rng = io.BytesIO(), np.random.default_rng(3)
    with av.open(film, "w", format="matroska") as output:
        stream: Any = output.add_stream(codec, rate=RATE_HZ)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, pixel_format
        for _ in range(5):
            pixels = np.repeat(rng.integers(0, 200, (HEIGHT, WIDTH, 1)).astype(np.uint8), 3, axis=2)
            pixels[20:28, 20:28, 0] += 50 if has_colours else 0
            for packet in stream.encode(av.VideoFrame.from_ndarray(pixels, "rgb24")):
                output.mux(packet)
        for packet in stream.encode():
            output.mux(packet)
    film.seek(0)
    with av.open(film) as recording:
        frames = [StreamFrame(0, FrameTime(0.0, 0.0), picture) for picture in recording.decode(video=0)]
        images = [frame.image() for frame in frames]
    expected = ((HEIGHT, WIDTH, 3), COLOURS) if has_colours else ((HEIGHT, WIDTH, 1), GREY)
    assert [(image.shape, bands) for image, bands in images] == [expected] * 5


async def test_rtsp_is_negotiated_and_received() -> None:
    async with rtsp_server() as (address, methods), receiving(settings_of(address)) as (receiver, clock):
        await until(clock, lambda: receiver.first_since(-math.inf) is not None)
        frame = receiver.first_since(-math.inf)
    assert frame is not None
    image, bands = frame.image()
    assert (image.shape, bands) == ((HEIGHT, WIDTH, 3), COLOURS)
    assert methods[:4] == ["OPTIONS", "DESCRIBE", "SETUP", "PLAY"]


@asynccontextmanager
async def receiving(settings: CameraSettings, max_pixels: int = 10_000) -> AsyncIterator[tuple[VideoReceiver, Any]]:
    clock = LoopClock()
    receiver = VideoReceiver(lambda: settings.place.url or "", clock, settings, max_pixels, lambda: None)
    task = asyncio.create_task(receiver.run())
    try:
        yield receiver, clock
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def until(clock: LoopClock, condition: Callable[[], bool]) -> None:
    async with clock.timeout_at(clock.now_s() + scaled_s(20.0)):
        while not condition():
            await clock.sleep(0.02)


@pytest.mark.slow
async def test_a_stream_without_times_arrives_a_latency_late_and_is_found_again_after_its_end() -> None:
    port = unused_port(socket.SOCK_STREAM)
    settings = settings_of(f"tcp://127.0.0.1:{port}", latency_s=0.3, latency_sigma_s=0.12)
    async with receiving(settings) as (receiver, clock):
        with sending(mpeg_ts(port)):
            await until(clock, lambda: receiver.first_since(-math.inf) is not None)
            frame = receiver.first_since(-math.inf)
            assert frame is not None
            assert frame.time.sigma_s == 0.12
            assert clock.now_s() - frame.time.at_s > 0.25
            image, bands = frame.image()
            assert (image.shape, bands) == ((HEIGHT, WIDTH, 3), ("red", "green", "blue"))
            await until(clock, lambda: receiver._received > 2 * KEPT_FRAMES)
            assert len(receiver._frames) == KEPT_FRAMES
        await until(clock, lambda: "stream" in receiver.problem)
        ended_at_s = clock.now_s()
        with sending(mpeg_ts(port)):
            await until(clock, lambda: receiver.first_since(ended_at_s) is not None)


async def test_pictures_beyond_the_limit_are_refused() -> None:
    port = unused_port(socket.SOCK_STREAM)
    with sending(mpeg_ts(port)):
        async with receiving(settings_of(f"tcp://127.0.0.1:{port}"), max_pixels=1000) as (receiver, clock):
            await until(clock, lambda: "64 x 48 pixels" in receiver.problem)
            assert receiver.first_since(-math.inf) is None


async def test_a_stream_that_is_not_there_is_named_at_the_deadline() -> None:
    settings = settings_of(f"tcp://127.0.0.1:{unused_port(socket.SOCK_STREAM)}")
    async with bench(ShutterVehicle(lambda _: None), settings) as network:
        receiver = network.vehicle()._captures._source._receiver  # type: ignore[attr-defined]
        await until(network.clock, lambda: "refused" in receiver.problem)
        with pytest.raises(LateFrameError, match=r"from vehicle 1: the stream fails: .*refused"):
            await network.vehicle().capture(deadline_s(network, 0.1))


async def test_a_receiver_that_fails_in_whatever_way_tries_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aos_drivers.frames.stream.receiver._FIRST_PAUSE_S", 0.01)
    attempts = []

    def fail() -> str:
        attempts.append(1)
        return b"Cam\xe9ra".decode()  # as the name of a session that is not UTF-8 did

    receiver = VideoReceiver(fail, LoopClock(), settings_of("rtsp://127.0.0.1/"), 1000, lambda: None)
    task = asyncio.create_task(receiver.run())
    await until(LoopClock(), lambda: len(attempts) > 1)
    assert "can't decode" in receiver.problem
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)


async def test_what_is_no_stream_is_not_opened() -> None:
    """FFmpeg knows hundreds of formats, playlists that name other addresses among them."""
    film = io.BytesIO()
    encode(film, "matroska", threading.Event(), frames=20)

    async def serve(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(film.getvalue())
        writer.close()

    async with await asyncio.start_server(serve, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        async with receiving(settings_of(f"tcp://127.0.0.1:{port}")) as (receiver, clock):
            await until(clock, lambda: receiver.problem.startswith("the stream fails"))
            assert receiver.first_since(-math.inf) is None


@pytest.mark.slow
async def test_a_frame_without_a_pose_of_its_time_is_refused(tmp_path: Path) -> None:
    port = unused_port()
    settings = settings_of(description_file(tmp_path, port), max_pose_age_s=0.3)
    with sending(rtp(port)):
        async with bench(ShutterVehicle(lambda _: None), settings) as network:
            await network.vehicle().capture(deadline_s(network, scaled_s(20.0)))
            network.silent.add(1)
            await network.clock.sleep(1.0)
            with pytest.raises(FrameRefusedError, match=r"max_pose_age_s"):
                await network.vehicle().capture(deadline_s(network, scaled_s(20.0)))
            state = network.vehicle().state.camera
    assert state is not None
    assert state.refused == 1
