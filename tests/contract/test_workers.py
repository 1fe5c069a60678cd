"""What every worker does, in this process or in one of its own; and what only the latter survives."""

from __future__ import annotations

import asyncio
import os
import select
import signal
import subprocess
import sys
import textwrap
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_drivers.frames.files.images import decode_image
from aos_gcs.errors import CaptureError, UnusableFramesError, WorkerError
from aos_gcs.groundmap.work import GroundSource, SearchedArea, add_frames
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.leg_order import ordered_on_map
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.ports import ThreadWorker, Worker
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import Segment
from aos_gcs.runtime.processes.workers import VIDEO
from aos_gcs.workers.process import ProcessWorker, WorkerSettings, open_worker
from tests.fakes import work
from tests.fakes.fleet import ORIGIN
from tests.fakes.shutter_vehicle import NoDownloads
from tests.timing import scaled_s

pytestmark = pytest.mark.realtime

LEAST_PRIORITY = 19
SETTINGS = WorkerSettings("Image analysis", 2 * 2**30, 60.0, ("numpy",))


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let processes start as slowly as they do beside other tests, whose priority is higher."""
    monkeypatch.setattr("aos_gcs.workers.process.RESTART_S", scaled_s(30.0))


@pytest.fixture(params=["thread", "process"])
async def worker(request: pytest.FixtureRequest) -> AsyncIterator[Worker]:
    if request.param == "thread":
        yield ThreadWorker()
        return
    async with open_worker(SETTINGS) as opened:
        yield opened


@pytest.fixture
async def process() -> AsyncIterator[ProcessWorker]:
    async with open_worker(SETTINGS) as opened:
        yield opened


@pytest.mark.parametrize("niceness", [SETTINGS.niceness, VIDEO.niceness])
async def test_a_process_steps_back_behind_the_flight_as_its_session_does(niceness: int) -> None:
    async with open_worker(replace(SETTINGS, niceness=niceness)) as process:
        own, autogroup = await process.run(work.priorities)
    assert own == min(LEAST_PRIORITY, os.getpriority(os.PRIO_PROCESS, 0) + niceness)
    assert not autogroup or autogroup.split()[-1] == str(niceness)


async def test_arrays_of_any_kind_go_there_and_come_back(worker: Worker) -> None:
    rng = np.random.default_rng(1)
    small, large = rng.random((3, 4), np.float32), rng.random((512, 512, 4), np.float32)
    for values in (small, large, large[::2, ::3], large.T, large[:0], np.asfortranarray(large[..., 0])):
        result = await worker.run(work.doubled, values, shift=1.0)
        np.testing.assert_array_equal(result, 2.0 * values + 1.0)
        result += 1.0  # it is the caller's own


async def test_results_stay_when_others_follow(worker: Worker) -> None:
    inputs = [np.full((200, 200), value, np.float32) for value in range(4)]
    results = await asyncio.gather(*(worker.run(work.doubled, values) for values in inputs))
    for values, result in zip(inputs, results, strict=True):
        np.testing.assert_array_equal(result, 2.0 * values)


async def test_errors_are_raised_as_they_are(worker: Worker) -> None:
    with pytest.raises(UnusableFramesError, match="none of the frames") as caught:
        await worker.run(work.refuse)
    assert caught.value.reasons == {3: "blurred"}
    with pytest.raises(ZeroDivisionError):
        await worker.run(work.divide_by_zero)
    assert await worker.run(work.doubled, np.ones(3, np.float32)) is not None


async def test_a_call_that_is_given_up_disturbs_no_other(worker: Worker) -> None:
    call = asyncio.ensure_future(worker.run(work.doubled, np.ones((512, 512), np.float32)))
    await asyncio.sleep(0.0)
    call.cancel()
    result = await worker.run(work.doubled, np.zeros(5, np.float32), shift=3.0)
    np.testing.assert_array_equal(result, np.full(5, 3.0))


# --- in a process -----------------------------------------------------------------------------------------------------


async def test_the_process_is_another_one(process: ProcessWorker) -> None:
    assert await process.run(work.process_id) not in {os.getpid(), os.getppid()}


async def test_what_cannot_be_sent_is_told(process: ProcessWorker) -> None:
    with pytest.raises(RuntimeError, match="UnsendableError: 1 and 2"):
        await process.run(work.raise_what_cannot_be_sent)


async def test_a_worker_that_is_killed_costs_one_result(process: ProcessWorker) -> None:
    first = await process.run(work.process_id)
    with pytest.raises(WorkerError, match=r"Image analysis has ended \(SIGKILL\)"):
        await process.run(work.end_oneself)
    assert await process.run(work.process_id) != first


async def test_a_worker_that_is_killed_between_two_calls_costs_one_result(process: ProcessWorker) -> None:
    os.kill(await process.run(work.process_id), signal.SIGKILL)
    with pytest.raises(WorkerError, match="Image analysis has ended"):
        await process.run(work.process_id)
    assert await process.run(work.process_id)


async def test_a_machine_without_room_for_a_process_is_asked_again(
    process: ProcessWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_args: object, **_kwargs: object) -> None:
        raise BlockingIOError("no more processes")

    await process.ready()
    with monkeypatch.context() as patched:
        patched.setattr(subprocess, "Popen", refuse)
        with pytest.raises(WorkerError, match="has ended"):
            await process.run(work.end_oneself)
        with pytest.raises(WorkerError, match="Image analysis is not running"):
            await process.run(work.process_id)
    with pytest.raises(WorkerError, match="Image analysis is not running"):
        await process.run(work.process_id)
    assert await process.run(work.process_id)


async def test_a_process_that_starts_slowly_is_given_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aos_gcs.workers.process.RESTART_S", 1e-6)
    process = ProcessWorker(SETTINGS)
    with pytest.raises(WorkerError, match="Image analysis is still starting"):
        await process.run(work.process_id)
    await process.ready()
    assert await process.run(work.process_id)
    await process.close()


async def test_a_worker_that_takes_too_much_memory_costs_one_result(process: ProcessWorker) -> None:
    with pytest.raises(WorkerError, match=r"Image analysis has run out of memory \(limit 2.0 GiB\)"):
        await process.run(work.take_memory)
    assert await process.run(work.process_id)


async def test_an_image_that_takes_too_much_memory_costs_one_frame(process: ProcessWorker) -> None:
    fetcher = NoDownloads(decoding=process)
    with pytest.raises(CaptureError, match=r"its image of 8 bytes cannot be decoded: .* out of memory"):
        await fetcher.decode(work.decode_greedily, bytes(8))
    png = bytes(cv2.imencode(".png", np.full((24, 32), 7, np.uint8))[1])
    image, bands = await fetcher.decode(decode_image, png)
    assert (image.shape, bands) == ((24, 32, 1), ("grey",))


async def test_a_worker_that_spins_is_stopped() -> None:
    async with open_worker(WorkerSettings("Image analysis", 2**30, 1.0, ("tests.fakes.work",))) as worker:
        await worker.ready()
        # A busy machine may let its successor wait for a second, too.
        worker._settings = replace(worker._settings, timeout_s=60.0)
        with pytest.raises(WorkerError, match="has taken longer than 1 s"):
            await worker.run(work.spin)
        assert await worker.run(work.process_id)


async def test_nothing_is_left_behind_of_a_worker_that_spins() -> None:
    process = ProcessWorker(SETTINGS)
    pid = await process.run(work.process_id)
    call = asyncio.ensure_future(process.run(work.spin))
    await asyncio.sleep(0.1)
    await process.close()
    with pytest.raises((WorkerError, asyncio.CancelledError)):
        await call
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="the end of a foreign process is not reported here")
def test_a_worker_ends_with_a_parent_that_is_killed() -> None:
    program = textwrap.dedent("""
        import asyncio, sys
        from aos_gcs.workers.process import WorkerSettings, open_worker
        from tests.fakes import work

        async def main():
            async with open_worker(WorkerSettings("Image analysis", 2**30, 60.0)) as worker:
                print(await worker.run(work.process_id), flush=True)
                await worker.run(work.spin)

        asyncio.run(main())
    """)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, env=environment) as parent:  # noqa: S603
        assert parent.stdout is not None
        pid = int(parent.stdout.readline())
        watched = os.pidfd_open(pid)
        try:
            parent.kill()
            parent.wait()
            # The descriptor of a process becomes readable when it ends.
            assert select.select([watched], [], [], scaled_s(30.0))[0], "the worker outlives its parent"
        finally:
            os.close(watched)


@pytest.mark.parametrize(
    ("message", "length", "reason"),
    [
        (b"\x80\x04cos\nsystem\n(S'true'\ntR.", None, "cannot be read"),
        (b"[]", None, "cannot be read"),
        (b'["result",[1000000000000],["bytes",0]]', None, "bytes of arrays"),
        (b"", 2**40, "1099511627776 bytes"),
    ],
)
async def test_a_worker_that_sends_what_is_no_answer_is_replaced(
    process: ProcessWorker, message: bytes, length: int | None, reason: str
) -> None:
    before = await process.run(work.process_id)
    with pytest.raises(WorkerError, match=f"Image analysis has sent .*{reason}"):
        await process.run(work.answer_with, message, length)
    assert await process.run(work.process_id) != before


async def test_legs_in_order_and_figures_of_segments_are_answered(process: ProcessWorker, tmp_path: Path) -> None:
    square = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
    plan = MissionPlan(vehicles=2, area_enu_m=square, launch_enu_m=(-100.0, -100.0), leg_spacing_m=50.0)
    legs = planned_legs(plan, 0.0)
    mass = np.zeros((20, 20))
    mass[:, -4:] = 0.01
    source = GroundSource(tmp_path / "ground", ORIGIN, 0.06, None)
    prior = AreaPrior(-100.0, 100.0, 10.0, mass)
    area = SearchedArea(square, 0.8, prior, (Segment("A 1", square),))
    ordered = await process.run(ordered_on_map, source, area, plan, 0.0, legs=legs, from_m=(-100.0, -100.0))
    assert ordered[0].start_enu_m[0] > 50.0
    assert len(ordered) == len(legs)
    report = await process.run(add_frames, source, (), area, pictures=False, flush=False)
    (segment,) = report.figures.segments
    assert (segment.name, segment.detection, segment.success) == ("A 1", 0.0, 0.0)
    assert segment.probability == pytest.approx(0.8)
