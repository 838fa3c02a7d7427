"""Where a submission's kernel runs: in a box made by bubblewrap if there is one, else in a folder of its own.

In the box there are the system's programs and Python with its packages, to be read only, kinlib and
kinlib_assignments, and an empty home folder; nothing else of the machine, no network, and no other process.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import psutil
from jupyter_client.manager import AsyncKernelManager

BOXED = "each notebook runs in a box (bubblewrap): it sees and changes nothing but itself"
OPEN = (
    "bubblewrap is not here, so notebooks run with limits only: they can read and change your files; "
    "install it (Debian: apt install bubblewrap) or grade what you trust"
)
LINKS = ("/bin", "/sbin", "/lib", "/lib32", "/lib64")
SYSTEM = (*LINKS, "/usr/bin", "/usr/sbin", "/usr/lib", "/usr/lib32", "/usr/lib64", "/usr/libexec", "/usr/share")
SYSTEM += ("/usr/local/bin", "/usr/local/lib", "/nix/store")
OF_PYTHON = ("bin", "lib", "lib64", "share", "etc", "pyvenv.cfg")  # what a prefix holds that is Python's
SETTINGS = ("ld.so.cache", "ld.so.conf", "ld.so.conf.d", "alternatives", "fonts", "localtime")
SOCKETS = Path("/tmp")  # a socket's whole path has room for 107 letters


@cache
def bubblewrap() -> str | None:
    """The program bwrap, if it is there and works: some systems forbid it to ordinary users."""
    found = shutil.which("bwrap")
    if found is None:
        return None
    tried = subprocess.run([found, *apart(), *system(), "true"], capture_output=True, check=False, timeout=60)
    return found if tried.returncode == 0 else None


def apart() -> list[str]:
    """Nothing is shared with the machine's other processes, and nothing outlives the grader."""
    return ["--unshare-all", "--die-with-parent", "--cap-drop", "ALL"]


def system() -> list[str]:
    """The system's own files, without those of its users."""
    options = ["--proc", "/proc", "--dev", "/dev"]
    for path in map(Path, SYSTEM):
        if path.is_symlink():
            options += ["--symlink", str(path.readlink()), str(path)]
        elif path.exists():
            options += ["--ro-bind", str(path), str(path)]
    for name in SETTINGS:
        options += ["--ro-bind-try", f"/etc/{name}", f"/etc/{name}"]
    return options


def python() -> list[Path]:
    """Where Python and its packages are: in the environment, and in what it was made from.

    An environment may stand in the project's own folder, so of a prefix only its known parts are taken.
    """
    prefixes = {Path(prefix) for prefix in (sys.prefix, sys.base_prefix, sys.exec_prefix)}
    prefixes |= {path.resolve() for path in prefixes} | {Path(sys.executable).resolve().parents[1]}
    parts = [prefix / part for prefix in prefixes for part in OF_PYTHON]
    libraries = [Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    libraries += [Path(path) for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
    return outermost(path for path in [*parts, *libraries] if path.exists())


def outermost(paths: Iterable[Path]) -> list[Path]:
    """Files and folders without those that lie in another one, or in the system's."""
    kept: list[Path] = []
    for path in sorted(set(paths), key=lambda path: len(path.parts)):
        if not any(path.is_relative_to(above) for above in [*kept, *map(Path, SYSTEM)]):
            kept.append(path)
    return kept


def around(home: Path, packages: dict[Path, Path], sockets: Path, megabytes: int) -> list[str]:
    """The words before a kernel's command that put it in a box.

    Parameters
    ----------
    home : Path
        The notebook's folder: empty at first, kept in memory, gone afterwards.
    packages : dict
        Further files and folders that can be read: where they are seen, and where they are.
    sockets : Path
        The folder in which the grader and the kernel meet.
    megabytes : int
        The room in the home folder and in /tmp.
    """
    room = ["--size", str(megabytes * 2**20), "--tmpfs"]
    command = [str(bubblewrap()), *apart(), *system(), *room, "/dev/shm", "--remount-ro", "/dev"]
    command += [*room, "/tmp", *room, str(home)]
    for seen, path in {**{path: path for path in python()}, **packages}.items():
        command += ["--ro-bind", str(path), str(seen)]
    command += ["--bind", str(sockets), str(sockets), "--remount-ro", "/", "--chdir", str(home)]
    return [*command, "--unsetenv", "JPY_PARENT_PID"]


class Kernel(AsyncKernelManager):
    """A kernel that is started with some words before its command, in surroundings of its own.

    `before`, `surroundings` and `said` (a file for what it says to a terminal) are set by `kernel_class`.
    """

    before: tuple[str, ...] = ()
    surroundings: dict[str, str]
    said: Path

    def format_kernel_cmd(self, extra_arguments: list[str] | None = None) -> list[str]:
        """This Python's kernel, whatever kernels the machine knows by the name."""
        self.kernel_spec.interrupt_mode = "message"  # a signal would end the box
        kernel = [sys.executable, "-m", "ipykernel_launcher", "-f", os.path.realpath(self.connection_file)]
        return [*self.before, *kernel, *(extra_arguments or [])]

    async def _async_launch_kernel(self, kernel_cmd: list[str], **options) -> None:
        with self.said.open("wb") as said:
            streams = {"stdout": subprocess.DEVNULL, "stderr": said}
            await super()._async_launch_kernel(kernel_cmd, **{**options, **streams, "env": dict(self.surroundings)})


def kernel_class(before: list[str], surroundings: dict[str, str], sockets: Path) -> type[Kernel]:
    """A class of kernels in one place; in a box, which has no network, they are met by sockets in a folder."""
    place = {"before": tuple(before), "surroundings": surroundings, "said": sockets.with_suffix(".said")}

    class Here(Kernel):
        def __init__(self, *given, **named):
            named["connection_file"] = str(sockets / "kernel.json")
            if before:
                named |= {"transport": "ipc", "ip": str(sockets / "k")}
            super().__init__(*given, **named)

    for name, value in place.items():
        setattr(Here, name, value)
    return Here


def family(pid: int | None) -> list[psutil.Process]:
    """A process and all that it started; none if there is no such process."""
    try:
        return [head := psutil.Process(pid), *head.children(recursive=True)] if pid else []
    except psutil.NoSuchProcess:
        return []
