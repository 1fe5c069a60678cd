"""Dask clusters: processes on this machine, or a scheduler that runs elsewhere."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from aos_gcs.errors import ConfigurationError, LinkError
from aos_gcs.extras import load_extra

CONNECT_TIMEOUT_S = 5.0
MAX_JOBS = 2 * (os.cpu_count() or 1)
"""Most processes that a command starts to compute: more than two per core wait for one another and take memory."""


def check_jobs(jobs: int | None) -> int | None:
    """Return the value of ``--jobs`` as it is, or None.

    Raises:
        ConfigurationError: this machine cannot bear so many processes, or it is no number of processes.
    """
    if jobs is not None and not 1 <= jobs <= MAX_JOBS:
        raise ConfigurationError(f"--jobs must lie within 1 and {MAX_JOBS}, two per core, but is {jobs}.")
    return jobs


@contextmanager
def local_cluster(workers: int) -> Iterator[Any]:
    """Yield the client of a cluster of processes on this machine, one thread each.

    Raises:
        ConfigurationError: Dask is not installed.
    """
    distributed = load_distributed()
    # Any free port for its dashboard, so that several can run at a time.
    options = {"memory_limit": None, "dashboard_address": "127.0.0.1:0", "silence_logs": logging.ERROR}
    with (
        distributed.LocalCluster(n_workers=workers, threads_per_worker=1, **options) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        yield client


@contextmanager
def remote_cluster(address: str) -> Iterator[Any]:
    """Yield the client of a running scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises:
        ConfigurationError: Dask is not installed.
        LinkError: the scheduler cannot be reached, or has no workers.
    """
    distributed = load_distributed()
    try:
        client = distributed.Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise LinkError(
            f"The scheduler {address} cannot be reached within {CONNECT_TIMEOUT_S:g} s: check the address, such as "
            "tcp://10.0.0.1:8786, and that 'dask scheduler' is running there."
        ) from error
    with client:
        if not client.nthreads():
            raise LinkError(f"The scheduler {address} has no workers: start 'dask worker {address}' first.")
        yield client


def load_distributed() -> Any:
    """Import Dask's scheduler, which takes a second.

    Raises:
        ConfigurationError: it is not installed.
    """
    distributed = load_extra("distributed", "lab", "Work on several processes or machines")
    # It reports everything that workers do, and importing it sets its own level; whatever matters raises.
    logging.getLogger("distributed").setLevel(logging.ERROR)
    return distributed
