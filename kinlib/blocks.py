"""Work in blocks: one after the other in this process, or many at a time on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from importlib import import_module
from itertools import islice
from typing import Any, TypeAlias, TypeVar

__all__ = ["Cluster", "run_in_blocks"]

Block = TypeVar("Block")
Answer = TypeVar("Answer")

Cluster: TypeAlias = Any
"""None, a number of processes, the address of a scheduler, or a dask.distributed.Client."""

AHEAD = 3
"""So many blocks a thread are handed to the cluster at a time: their answers are all that is held in memory."""

TRIES = 5
"""So often a block is tried again when its worker is lost."""


def run_in_blocks(
    function: Callable[[Block], Answer], blocks: Iterable[Block], cluster: Cluster = None
) -> Iterator[Answer]:
    """The answers for all blocks: in their order without a cluster, with one as they come.

    Parameters
    ----------
    function : callable
        Of one block; on a cluster it is sent to the workers.
    blocks : iterable
        Read as it is needed.
    cluster : int, str or dask.distributed.Client, optional
        How many processes to start on this machine (in a script below ``if __name__ == "__main__"``), or the address of
        a scheduler, or a client.

    Raises
    ------
    ImportError
        If a cluster is asked for and Dask is not installed.

    Examples
    --------
    >>> list(run_in_blocks(lambda n: n * n, range(4)))
    [0, 1, 4, 9]
    """
    if cluster is None:
        yield from map(function, blocks)
        return
    try:
        distributed: Any = import_module("dask.distributed")
    except ImportError as error:
        raise ImportError('a cluster needs Dask: pip install "kinlib[scale]"') from error
    with ExitStack() as stack:
        client = _client(distributed, cluster, stack)

        def submitted(some: Iterable[Block]) -> list[Any]:
            return [client.submit(function, block, pure=False, retries=TRIES) for block in some]

        remaining, threads = iter(blocks), sum(client.nthreads().values())
        running = distributed.as_completed(submitted(islice(remaining, AHEAD * max(1, threads))), loop=client.loop)
        for future in running:
            answer = future.result()
            running.update(submitted(islice(remaining, 1)))
            yield answer


def _client(distributed: Any, cluster: Any, stack: ExitStack) -> Any:
    """A client as it is given, or one of its own, which is closed with the stack."""
    if isinstance(cluster, distributed.Client):
        return cluster
    if isinstance(cluster, int):
        own = distributed.LocalCluster(
            n_workers=cluster, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
        )
        cluster = stack.enter_context(own)
    return stack.enter_context(distributed.Client(cluster, set_as_default=False))
