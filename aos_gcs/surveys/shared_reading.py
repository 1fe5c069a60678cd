"""Images that several processes need at the same time: each is read by one of them, which lends it to the others.

Images are divided into chunks by their indices, which every process goes through in order. It reads its own share of a
chunk, waits for what others read of it, and adds all. Memory holds two chunks: nobody reads for the next but one before
all are done with the present one. The process that is in the earliest chunk never waits for its own share, so that
processes cannot wait for each other in a circle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.integral import BATCH_FRAMES
from aos_gcs.imaging.model import Frame
from aos_gcs.surveys.integration import BATCH_BYTES, Read, Work, read_with_levels, seen_images
from aos_gcs.surveys.tiles import RasterTile

_TYPES = (np.dtype(np.uint8), np.dtype(np.uint16), np.dtype(np.float32))
"""Types of pixels, by their numbers in the memory."""
_BROKEN = -1
"""Number in place of a type: there is a reason instead of pixels."""
_HEAD_BYTES = 64
_LARGEST_SHARE = 4
"""Part of the memory of a process, one in so many, that lent images may take."""
_LOOK_S = 0.2
"""Time between two looks at whether the results are still wanted."""
_READ, _ADDED = 0, 1


class StoppedError(Exception):
    """The results are not wanted any more."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadingPlan:
    """Division of images among processes that integrate a group of tiles each, side by side."""

    seers: dict[int, tuple[int, ...]]
    """Numbers of the groups that need an image, by its index."""
    groups: int
    """Number of groups."""
    chunk_images: int
    slot_bytes: int
    """Memory of one image."""

    @classmethod
    def of(cls, work: Work, groups: Sequence[Sequence[RasterTile]]) -> ReadingPlan | None:
        """Return the division; None where nothing is gained, or images are so large that each process reads its own."""
        if len(groups) < 2 or work.trim is not None:
            return None
        seers: dict[int, tuple[int, ...]] = {}
        for number, group in enumerate(groups):
            for index in seen_images(group):
                seers[index] = (*seers.get(index, ()), number)
        shared = [index for index, numbers in seers.items() if len(numbers) > 1]
        if not shared:
            return None
        slot_bytes = max(_slot_bytes(work, index) for index in shared)
        chunk_images = max(len(groups), min(BATCH_FRAMES, BATCH_BYTES // slot_bytes))
        if 2 * chunk_images * slot_bytes > work.max_bytes // _LARGEST_SHARE:
            return None
        return cls(seers, len(groups), chunk_images, slot_bytes)

    def reader(self, index: int) -> int:
        """Return which group's process reads an image."""
        numbers = self.seers[index]
        return numbers[index % len(numbers)]

    @property
    def memory_bytes(self) -> int:
        """Memory that the processes share for images, and for how far each is."""
        return self.groups * _HEAD_BYTES + 2 * self.chunk_images * self.slot_bytes


class SharedReading:
    """Implements :class:`~aos_gcs.surveys.integration.Reading` for one of the processes.

    Args:
        plan: who reads what.
        group: number of the process's group of tiles.
        work: settings that all tiles share.
        cell_m: edge of their cells.
        memory: memory that the processes share, zeros at first, of the size in the plan.
        condition: condition that the processes share (``multiprocessing.Condition``).
        is_stopped: tells whether the results are not wanted any more.
    """

    def __init__(
        self,
        plan: ReadingPlan,
        group: int,
        work: Work,
        cell_m: float | None,
        *,
        memory: NDArray[np.uint8],
        condition: Any,
        is_stopped: Callable[[], bool],
    ) -> None:
        self._plan, self._group, self._work, self._cell_m = plan, group, work, cell_m
        self._condition, self._is_stopped = condition, is_stopped
        heads = memory[: plan.groups * _HEAD_BYTES].view(np.int64).reshape(plan.groups, -1)
        self._done = heads[:, : _ADDED + 1]
        """Number of chunks that each process has read its share of, and that it has added, shape (groups, 2)."""
        self._slots = memory[plan.groups * _HEAD_BYTES :].reshape(2 * plan.chunk_images, plan.slot_bytes)

    def batches(self, indices: Sequence[int]) -> Iterator[list[tuple[int, Read]]]:
        """See :class:`~aos_gcs.surveys.integration.Reading`."""
        plan = self._plan
        for chunk, own_indices in groupby(indices, lambda index: index // plan.chunk_images):
            needed = list(own_indices)
            # The chunks before it are over, or show nothing of these tiles.
            self._note(_ADDED, chunk)
            own = {index: self._read(index) for index in needed if plan.reader(index) == self._group}
            self._wait(_ADDED, range(plan.groups), chunk - 1)
            for index, read in own.items():
                if len(plan.seers[index]) > 1:
                    self._lend(index, read)
            self._note(_READ, chunk + 1)
            self._wait(_READ, {plan.reader(index) for index in needed}, chunk + 1)
            yield [(index, own[index] if index in own else self._borrowed(index)) for index in needed]
        for what in (_READ, _ADDED):
            self._note(what, np.iinfo(np.int64).max)

    def _read(self, index: int) -> Read:
        return read_with_levels(self._work, self._cell_m, index)

    def _note(self, what: int, chunks: int) -> None:
        with self._condition:
            self._done[self._group, what] = chunks
            self._condition.notify_all()

    def _wait(self, what: int, groups: Iterable[int], chunks: int) -> None:
        """Wait until the processes of these groups have done so many chunks."""
        with self._condition:
            while min(int(self._done[group, what]) for group in groups) < chunks:
                if self._is_stopped():
                    raise StoppedError
                self._condition.wait(_LOOK_S)

    # --- the memory -----------------------------------------------------------------------------------------------

    def _slot(self, index: int) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
        """Return the head of an image's place, and the bytes behind it."""
        slot = self._slots[index % len(self._slots)]
        return slot[:_HEAD_BYTES].view(np.int64), slot[_HEAD_BYTES:]

    def _lend(self, index: int, read: Read) -> None:
        head, content = self._slot(index)
        if isinstance(read, str):
            text = np.frombuffer(read.encode()[: len(content)], np.uint8)
            head[:2], content[: len(text)] = (_BROKEN, len(text)), text
            return
        frame, levels = read
        pixels = np.ascontiguousarray(frame.image).reshape(-1).view(np.uint8)
        head[:2], content[: len(pixels)] = (_TYPES.index(frame.image.dtype), levels is not None), pixels
        if levels is not None:
            marks = levels.image.reshape(-1)
            content[len(pixels) : len(pixels) + len(marks)] = marks

    def _borrowed(self, index: int) -> Read:
        head, content = self._slot(index)
        kind, number = int(head[0]), int(head[1])
        if kind == _BROKEN:
            return content[:number].tobytes().decode(errors="replace")
        image, bands, dtype = self._work.images[index], self._work.bands, _TYPES[kind]
        shape = image.camera.height_px, image.camera.width_px
        end = shape[0] * shape[1] * len(bands) * dtype.itemsize
        pixels = content[:end].view(dtype).reshape(*shape, len(bands))
        frame = Frame(index, pixels, bands, image.pose, image.camera)
        if not number:
            return frame, None
        marks = content[end : end + shape[0] * shape[1]].reshape(*shape, 1)
        return frame, replace(frame, image=marks, bands=("anomaly",))


def _slot_bytes(work: Work, index: int) -> int:
    """Return the memory of an image and its levels of anomaly."""
    image = work.images[index]
    pixels = image.camera.height_px * image.camera.width_px
    value_bytes = max(dtype.itemsize for dtype in _TYPES) if image.dtype is None else image.dtype.itemsize
    size = _HEAD_BYTES + pixels * (len(work.bands) * value_bytes + (work.detector is not None))
    return -(-size // _HEAD_BYTES) * _HEAD_BYTES
