"""The tiles of a survey on several processes or machines, by Dask.

Workers read the images themselves: they need the same folders at the same paths, and the same version of this program.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from typing import Any

from aos_gcs.cluster import load_distributed
from aos_gcs.errors import AosError, LinkError
from aos_gcs.surveys.integration import Advance, TileResult, Work, integrate_tiles
from aos_gcs.surveys.tiles import RasterTile, grouped

GROUPS_PER_WORKER = 4
"""Number of groups, so that no worker idles long while another computes the last one."""


def integrate_on_cluster(
    client: Any, work: Work, tiles: Sequence[RasterTile], advance: Advance
) -> Iterator[list[TileResult]]:
    """Integrate tiles on the workers of a cluster; groups come in the order in which they are done.

    Args:
        client: see :mod:`aos_gcs.cluster`.
        work: settings that all tiles share.
        tiles: to be integrated.
        advance: called with the number of further tiles that are done.

    Raises:
        AosError: as :func:`~aos_gcs.surveys.integration.integrate_tiles`; also if workers are lost.
    """
    distributed = load_distributed()
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
            raise LinkError(
                f"The cluster was lost while it integrated ({error}): give its workers more memory, or a smaller "
                "--max-memory, and check that it still runs."
            ) from error
        advance(len(futures.pop(future)))
        # Results stay on the workers until nobody holds their future.
        del future
        yield results
