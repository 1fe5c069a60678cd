"""Memory that two processes share, and requests in it, from the process that started the other one."""

from __future__ import annotations

import fcntl
import mmap
import os
import pickle
import tempfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

_ALIGNMENT = 64
_MIN_BYTES = 16 * 1024
"""Smaller arrays travel inside the message."""


class Arena:
    """Shared memory behind a file without a name: the kernel frees it with its last user, however that ends.

    It grows and never shrinks. One process writes, the other reads when it is told to.
    """

    def __init__(self, fd: int) -> None:
        self.fd = fd
        self._bytes: NDArray[np.uint8] = np.empty(0, np.uint8)

    @classmethod
    def create(cls) -> Arena:
        """Return an empty arena."""
        if hasattr(os, "memfd_create"):
            fd = os.memfd_create("aos-gcs", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
            # A process that makes it smaller would end the other one when that reads.
            fcntl.fcntl(fd, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_SEAL)
            return cls(fd)
        with tempfile.TemporaryFile() as file:
            return cls(os.dup(file.fileno()))

    def first(self, size: int) -> NDArray[np.uint8]:
        """Return the first bytes; the arena grows where it is smaller. Former arrays stay valid."""
        if size > len(self._bytes):
            if self.size() < size:
                os.ftruncate(self.fd, size + size // 4)
            self._bytes = np.frombuffer(mmap.mmap(self.fd, self.size()), np.uint8)
        return self._bytes[:size]

    def size(self) -> int:
        """Return how many bytes there are."""
        return os.fstat(self.fd).st_size

    def close(self) -> None:
        """Give the memory back, once no array refers to it any more."""
        self._bytes = np.empty(0, np.uint8)
        if self.fd >= 0:
            os.close(self.fd)
            self.fd = -1


def pack(value: object, arena: Arena) -> bytes:
    """Put the arrays of an object into an arena, and return the rest as a message for :func:`unpack`."""
    buffers: list[pickle.PickleBuffer] = []

    def keep_inside(buffer: pickle.PickleBuffer) -> bool:
        if memoryview(buffer).nbytes < _MIN_BYTES:
            return True
        buffers.append(buffer)
        return False

    head = pickle.dumps(value, protocol=5, buffer_callback=keep_inside)
    raws = [np.frombuffer(buffer.raw(), np.uint8) for buffer in buffers]
    starts, size = layout([len(raw) for raw in raws])
    memory = arena.first(size)
    for start, raw in zip(starts, raws, strict=True):
        # Arrays are copied without the interpreter's lock.
        memory[start : start + len(raw)] = raw
    return pickle.dumps((head, [len(raw) for raw in raws]))


def unpack(message: bytes, arena: Arena) -> Any:
    """Return the object of a message of the process that started this one; arrays are valid until the next message.

    Args:
        message: what :func:`pack` has returned.
        arena: the other end of its arena.
    """
    head, sizes = pickle.loads(message)  # noqa: S301 - the service trusts no worker, but a worker its service
    starts, size = layout(sizes)
    memory = arena.first(size)
    parts = [memory[start : start + length] for start, length in zip(starts, sizes, strict=True)]
    return pickle.loads(head, buffers=parts)  # noqa: S301


def layout(sizes: list[int]) -> tuple[list[int], int]:
    """Return where each buffer starts, and the size of all."""
    starts, end = [], 0
    for size in sizes:
        starts.append(end)
        end += -(-size // _ALIGNMENT) * _ALIGNMENT
    return starts, end
