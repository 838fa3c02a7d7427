"""Kernels of Jupyter that start at once: a process that has imported what submissions use is forked for each.

They are kernels like any other, one for each submission, and know nothing of one another.
"""

from __future__ import annotations

import multiprocessing
import os
import pkgutil
import signal
from multiprocessing import forkserver
from unittest.mock import patch

import kinlib_assignments

SURROUNDINGS = {"MPLBACKEND": "agg", "OPENBLAS_NUM_THREADS": "1"}  # read when the libraries are imported
MODULES = [f"kinlib_assignments.{module.name}" for module in pkgutil.iter_modules(kinlib_assignments.__path__)]
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(["ipykernel.kernelapp", "matplotlib.pyplot", "pytest", "sympy", *MODULES])


def prepare() -> None:
    """Start the process that will be forked."""
    with patch.dict(os.environ, SURROUNDINGS):
        forkserver.ensure_running()


def launch(command: list[str], *, env: dict[str, str], cwd: str, **options) -> Kernel:
    """Start a kernel; takes the place of ``jupyter_client.launch_kernel``."""
    return Kernel(command[command.index("-f") :], env, cwd)


class Kernel:
    """The process of a kernel, with as much of a `subprocess.Popen` as its manager asks for."""

    stdin = stdout = stderr = None

    def __init__(self, arguments: list[str], environment: dict[str, str], folder: str):
        ready, tell = FORKS.Pipe(duplex=False)
        given = (arguments, dict(environment), str(folder), tell)
        self._process = FORKS.Process(target=be_a_kernel, args=given, daemon=True)
        self._process.start()
        self.pid = self._process.pid
        ready.recv()  # from here on it leads a group of its own, which its manager may kill
        ready.close(), tell.close()

    def poll(self) -> int | None:
        return self._process.exitcode

    def wait(self) -> int | None:
        self._process.join()
        return self._process.exitcode

    def send_signal(self, number: int) -> None:
        os.kill(self.pid, number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def be_a_kernel(arguments: list[str], environment: dict[str, str], folder: str, tell) -> None:
    """What a forked process does."""
    from ipykernel import kernelapp

    os.setsid()
    tell.send("ready")
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    for stream in (1, 2):  # what it says to a terminal
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    ends_with_its_parent = f"--IPKernelApp.parent_handle={os.getppid()}"
    kernelapp.launch_new_instance(argv=[*arguments, ends_with_its_parent])
