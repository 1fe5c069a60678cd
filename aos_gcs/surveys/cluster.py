"""The tiles of a survey on several processes or machines, by Dask.

Workers read the images themselves: they need the same folders at the same paths, and the same version of this program.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from typing import Any

from aos_gcs.errors import AosError, ConfigurationError
from aos_gcs.extras import load_extra
from aos_gcs.surveys.integration import Advance, TileResult, Work, integrate_tiles
from aos_gcs.surveys.tiles import Tile, grouped

CONNECT_TIMEOUT_S = 5.0

GROUPS_PER_WORKER = 4
"""So that none idles long while another computes the last group."""


@contextmanager
def local_cluster(workers: int) -> Iterator[Any]:
    """Yield the client of a cluster of processes on this machine, one thread each.

    Raises:
        ConfigurationError: if Dask is not installed.
    """
    distributed = _distributed()
    with ExitStack() as stack:
        cluster = stack.enter_context(
            distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0")
        )
        yield stack.enter_context(distributed.Client(cluster))


@contextmanager
def remote_cluster(address: str) -> Iterator[Any]:
    """Yield the client of a running scheduler.

    Raises:
        ConfigurationError: if Dask is not installed, or the scheduler cannot be reached.
    """
    distributed = _distributed()
    try:
        client = distributed.Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"The scheduler {address} cannot be reached within {CONNECT_TIMEOUT_S:g} s: check the address and that "
            "'dask scheduler' is running there."
        ) from error
    with client:
        if not client.nthreads():
            raise ConfigurationError(f"The scheduler {address} has no workers: start 'dask worker {address}' first.")
        yield client


def integrate_on_cluster(
    client: Any, work: Work, tiles: Sequence[Tile], advance: Advance
) -> Iterator[list[TileResult]]:
    """Integrate tiles on the workers of a cluster; groups come in the order in which they are done.

    Args:
        client: see :func:`local_cluster` and :func:`remote_cluster`.
        work: what the tiles have in common.
        tiles: to be integrated.
        advance: is told how many tiles are done.

    Raises:
        AosError: as :func:`~aos_gcs.surveys.integration.integrate_tiles`; also if workers are lost.
    """
    distributed = _distributed()
    workers = len(client.nthreads())
    groups = grouped(tiles, work.cell_bytes, work.max_bytes, GROUPS_PER_WORKER * workers)
    shared = client.scatter(work, broadcast=True, hash=False)
    # Not pure: equal work is to be done again when it is asked for again, images may have changed.
    futures = {client.submit(integrate_tiles, shared, group, pure=False): group for group in groups}
    done = distributed.as_completed(list(futures), loop=client.loop)
    for future in done:
        try:
            results: list[TileResult] = future.result()
        except AosError:
            client.cancel(list(futures))
            raise
        except (distributed.scheduler.KilledWorker, CancelledError, OSError) as error:
            raise ConfigurationError(
                f"The cluster was lost while it integrated ({error}): give its workers more memory, or a smaller "
                "--max-memory, and check that it still runs."
            ) from error
        advance(len(futures.pop(future)))
        # Results stay on the workers until nobody holds their future.
        del future
        yield results


def _distributed() -> Any:
    distributed = load_extra("distributed", "lab", "Integrating on several processes or machines")
    # It reports everything that workers do, and importing it sets its own level.
    logging.getLogger("distributed").setLevel(logging.ERROR)
    return distributed
