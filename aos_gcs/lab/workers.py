"""Workers that compute a campaign: this process, others on this machine, or a cluster, with equal results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, TypeVar

import pyarrow as pa

from aos_gcs.cluster import check_jobs, load_distributed, local_cluster, remote_cluster
from aos_gcs.errors import LinkError
from aos_gcs.lab.campaign import run_initialisation
from aos_gcs.lab.initialisation import Initialisation
from aos_gcs.lab.results import ResultFolder

Item = TypeVar("Item")
Result = TypeVar("Result")


def compute(
    results: ResultFolder,
    advance: Callable[[int], None],
    *,
    jobs: int = 1,
    scheduler: str | None = None,
) -> None:
    """Compute what is missing of a campaign; every finished initialisation is on the disk at once.

    Args:
        results: folder that receives the rows.
        advance: called after each finished initialisation with 1.
        jobs: processes on this machine.
        scheduler: address of a Dask scheduler, such as ``tcp://10.0.0.1:8786``, in place of ``jobs``.

    Raises:
        ConfigurationError: ``jobs`` is out of its range, or a run cannot be made as asked.
        LinkError: the scheduler cannot be reached, has no workers, or has lost them.
    """
    work: Callable[[Initialisation], pa.Table] = partial(run_initialisation, results.campaign)
    for initialisation, table in compute_each(work, results.missing(), jobs=jobs, scheduler=scheduler):
        results.write(initialisation, table)
        advance(1)


def compute_each(
    work: Callable[[Item], Result], items: tuple[Item, ...], *, jobs: int = 1, scheduler: str | None = None
) -> Iterator[tuple[Item, Result]]:
    """Go through items with their results, as they are ready; arguments and errors as of :func:`compute`."""
    check_jobs(jobs)
    if scheduler is not None:
        yield from _on_cluster(work, items, remote_cluster(scheduler))
    elif min(jobs, len(items)) > 1:
        yield from _on_cluster(work, items, local_cluster(min(jobs, len(items))))
    else:
        yield from ((item, work(item)) for item in items)


def _on_cluster(
    work: Callable[[Item], Result], items: tuple[Item, ...], connection: AbstractContextManager[Any]
) -> Iterator[tuple[Item, Result]]:
    distributed = load_distributed()
    with connection as client:
        tasks = {client.submit(work, item, pure=False): item for item in items}
        try:
            for future in distributed.as_completed(list(tasks), loop=client.loop):
                yield tasks.pop(future), future.result()
        except (distributed.KilledWorker, CancelledError) as error:
            raise LinkError(f"Workers were lost ({error}); run the command again to go on where it stopped.") from error
        except ImportError as error:
            raise LinkError(f"A worker lacks a package ({error}); install aos-gcs[lab] on all workers.") from error
