"""Work for workers: some of it ends badly."""

from __future__ import annotations

import os
import signal
import struct
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import UnusableFramesError


def doubled(values: NDArray[np.float32], *, shift: float = 0.0) -> NDArray[np.float32]:
    return np.asarray(2.0 * values + np.float32(shift), dtype=np.float32)


def process_id() -> int:
    return os.getpid()


def priorities() -> tuple[int, str]:
    """Return the niceness of the process, and what the kernel tells of that of its session; empty without one."""
    autogroup = Path("/proc/self/autogroup")
    return os.getpriority(os.PRIO_PROCESS, 0), autogroup.read_text(encoding="ascii") if autogroup.is_file() else ""


def refuse() -> None:
    raise UnusableFramesError("none of the frames can be used", {3: "blurred"})


def divide_by_zero() -> float:
    return 1 / int(not os.getpid())


def end_oneself() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def spin(duration_s: float = 60.0) -> None:
    end_s = time.monotonic() + duration_s
    while time.monotonic() < end_s:
        pass


def decode_greedily(data: bytes) -> int:
    return take_memory(len(data) * 2**30)


def take_memory(size: int = 8 * 2**30) -> int:
    taken = np.ones(size, dtype=np.uint8)
    return len(taken)


class UnsendableError(Exception):
    def __init__(self, one: int, other: int) -> None:
        super().__init__(f"{one} and {other}")


def raise_what_cannot_be_sent() -> None:
    raise UnsendableError(1, 2)


def answer_with(message: bytes, length: int | None = None) -> None:
    """Send bytes of one's own, as a worker does that somebody else has taken over."""
    size = len(message) if length is None else length
    os.write(int(sys.argv[1]), struct.pack("!Q", size) + message)
    spin()
