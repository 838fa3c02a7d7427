"""Sweeps that outgrow one machine: all functions take batches, so Dask's map_blocks is all it takes."""

import os
import signal
import socket
from contextlib import suppress

import dask.array as da
import numpy as np
import pytest
from dask.distributed import Client, LocalCluster

from kinlib import Brief, DualQuaternion, ZGrid, goldberg_linkages, search
from kinlib.gallery import THREE_POSES
from kinlib.testing import random_poses


def longest_links(block: np.ndarray) -> np.ndarray:
    """The longest link of each of the eight 5R linkages through poses of shape (n, 3, 8); shape (n, 8)."""
    linkages = goldberg_linkages(*(DualQuaternion(block[:, number]) for number in range(3)), 0.3 + 0.8j)
    return np.stack([np.max([row.distance for row in x.denavit_hartenberg()], axis=0) for x in linkages], axis=-1)


@pytest.fixture(scope="module")
def client():
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0")
    with cluster, Client(cluster) as client:
        yield client


def test_a_sweep_on_a_cluster_is_the_sweep_on_one_machine(client):
    poses = np.stack([pose.coeffs for pose in random_poses(3, seed=3, shape=(400,))], axis=1)
    blocks = da.from_array(poses, chunks=(100, 3, 8))
    lengths = blocks.map_blocks(longest_links, dtype=float, chunks=(100, 8), drop_axis=2).compute()
    assert len(client.scheduler_info()["workers"]) == 2
    np.testing.assert_array_equal(lengths, longest_links(poses))


def test_a_search_on_a_cluster_that_loses_a_worker_finds_the_same_to_the_last_bit(client):
    grid, brief = ZGrid(-3 - 3j, 3 + 3j, (12, 6)), Brief(longest_bar=3.0, travel=5.0)
    told = []

    def kill_one(done, count):
        told.append(done)
        if done == 2:
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)

    alone = search(*THREE_POSES, grid, brief, keep=3, block=6, planes=(2,))
    together = search(*THREE_POSES, grid, brief, keep=3, block=6, planes=(2,), cluster=client, progress=kill_one)
    assert told == list(range(1, 13))
    assert together.left == alone.left
    for one, other in zip(alone.linkages, together.linkages, strict=True):
        assert all((f.coeffs == g.coeffs).all() for f, g in zip(one.factors, other.factors, strict=True))
    assert {name: values.tolist() for name, values in together.measures.items()} == {
        name: values.tolist() for name, values in alone.measures.items()
    }


def test_a_search_starts_processes_of_its_own():
    """Without a client that is the default one, and beside another cluster, which has Dask's usual port."""
    grid = ZGrid(-3 - 3j, 3 + 3j, (6, 6))
    alone = search(*THREE_POSES, grid, best="longest_bar", keep=2, planes=(1,))
    with socket.socket() as usual_port:
        with suppress(OSError):
            usual_port.bind(("127.0.0.1", 8787))
            usual_port.listen()
        together = search(*THREE_POSES, grid, best="longest_bar", keep=2, planes=(1,), block=12, cluster=1)
    assert together.z.tolist() == alone.z.tolist()
