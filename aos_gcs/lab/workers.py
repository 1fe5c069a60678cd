"""Who computes a campaign: this process, workers on this machine, or a cluster; the results are the same."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from typing import TYPE_CHECKING

import pyarrow as pa

from aos_gcs.errors import ConfigurationError, LinkError
from aos_gcs.lab.campaign import run_initialisation
from aos_gcs.lab.initialisation import Initialisation
from aos_gcs.lab.results import ResultFolder

if TYPE_CHECKING:
    from distributed import Client

CONNECT_TIMEOUT_S = 10.0
MAX_JOBS = 256

Work = Callable[[Initialisation], pa.Table]
Results = Iterator[tuple[Initialisation, pa.Table]]


def compute(
    results: ResultFolder,
    advance: Callable[[int], None],
    *,
    jobs: int = 1,
    scheduler: str | None = None,
) -> None:
    """Compute what is missing of a campaign; every finished initialisation is on the disk at once.

    Args:
        results: where to.
        advance: called after each finished initialisation with 1.
        jobs: processes on this machine.
        scheduler: address of a Dask scheduler, such as ``tcp://10.0.0.1:8786``, in place of ``jobs``.

    Raises:
        ConfigurationError: ``jobs`` is out of its range, or a run cannot be made as asked.
        LinkError: the scheduler cannot be reached, has no workers, or has lost them.
    """
    if not 1 <= jobs <= MAX_JOBS:
        raise ConfigurationError(f"jobs must lie within 1 and {MAX_JOBS}, but is {jobs}.")
    missing = results.missing()
    work = partial(run_initialisation, results.campaign)
    for initialisation, table in _computed(work, missing, min(jobs, len(missing)), scheduler):
        results.write(initialisation, table)
        advance(1)


def _computed(work: Work, missing: tuple[Initialisation, ...], jobs: int, scheduler: str | None) -> Results:
    """Yield the results as they are ready."""
    if scheduler is not None:
        yield from _on_cluster(work, missing, _remote(scheduler))
    elif jobs > 1:
        yield from _on_cluster(work, missing, _local(jobs))
    else:
        yield from ((initialisation, work(initialisation)) for initialisation in missing)


def _on_cluster(work: Work, missing: tuple[Initialisation, ...], connection: AbstractContextManager[Client]) -> Results:
    from distributed import KilledWorker, as_completed  # noqa: PLC0415 - takes a second to import

    # Whatever matters raises; the rest would tear the progress bar apart.
    logging.getLogger("distributed").setLevel(logging.ERROR)
    with connection as client:
        tasks = {client.submit(work, initialisation, pure=False): initialisation for initialisation in missing}
        try:
            for future in as_completed(list(tasks)):
                yield tasks.pop(future), future.result()
        except (KilledWorker, CancelledError) as error:
            raise LinkError(f"Workers were lost ({error}); run the command again to go on where it stopped.") from error
        except ImportError as error:
            raise LinkError(f"A worker lacks a package ({error}); install aos-gcs[lab] on all workers.") from error


@contextmanager
def _local(jobs: int) -> Iterator[Client]:
    from distributed import Client, LocalCluster  # noqa: PLC0415 - takes a second to import

    # Any free port, so that several campaigns can run at a time.
    options = {"memory_limit": None, "dashboard_address": "127.0.0.1:0", "silence_logs": logging.ERROR}
    with LocalCluster(n_workers=jobs, threads_per_worker=1, **options) as cluster, Client(cluster) as client:
        yield client


@contextmanager
def _remote(scheduler: str) -> Iterator[Client]:
    from distributed import Client  # noqa: PLC0415 - takes a second to import

    try:
        client = Client(scheduler, timeout=CONNECT_TIMEOUT_S)
    except (OSError, ValueError) as error:
        raise LinkError(
            f"The scheduler {scheduler} cannot be reached within {CONNECT_TIMEOUT_S:g} s ({error}); check the address, "
            "such as tcp://10.0.0.1:8786, and that dask scheduler runs there."
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_TIMEOUT_S)
        except TimeoutError as error:
            raise LinkError(
                f"The scheduler {scheduler} has no workers; start some with dask worker {scheduler}."
            ) from error
        yield client
