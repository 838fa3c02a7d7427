"""Samplers: functions that do some work once and return what it cost, in seconds or bytes."""

import os
import subprocess
import sys
import time
import timeit
import tracemalloc
from collections.abc import Callable
from functools import wraps
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Installed packages come with their bytecode; a source tree has to be allowed to keep its own.
_ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}

Sampler = Callable[[], float]
Setup = Callable[[int], Sampler]  # makes the sampler for a batch of so many problems


def timed(setup: Callable[[int], Callable]) -> Setup:
    """Time the function that a set-up returns: the best of about a tenth of a second."""

    @wraps(setup)
    def ready(size: int) -> Sampler:
        timer = timeit.Timer(setup(size))
        once = timer.timeit(1)
        calls = max(1, round(2e-3 / once))
        repeats = min(50, max(1, round(0.1 / (once * calls))))
        return lambda: min(timer.repeat(repeats, calls)) / calls

    return ready


def measured_in_bytes(setup: Callable[[int], Callable]) -> Setup:
    """The most memory that NumPy and Python held during the call, beyond what they held before it."""

    @wraps(setup)
    def ready(size: int) -> Sampler:
        return lambda: _peak(setup(size))

    return ready


def _peak(work: Callable) -> int:
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def importing(module: str, names: str = "") -> Setup:
    """The time of an import in a fresh interpreter, or of some names, without that interpreter's own start."""
    statement = f"from {module} import {names}" if names else f"import {module}"
    code = f"from time import perf_counter as now; start = now(); {statement}; print(now() - start)"
    return lambda size: lambda: _printed_number(["-c", code])


def _printed_number(arguments: list[str], limit: float | None = None) -> float:
    command = [sys.executable, *arguments]
    run = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT, env=_ENVIRONMENT, timeout=limit)
    return float(run.stdout.split()[-1])


def limited(module: str, name: str, seconds: float) -> Setup:
    """The number that a module prints for ``name``; infinity if that takes too long, NaN if it fails."""

    def sample() -> float:
        try:
            return _printed_number(["-m", module, name], seconds)
        except subprocess.TimeoutExpired:
            return float("inf")
        except subprocess.CalledProcessError as error:
            print(error.stderr, file=sys.stderr)
            return float("nan")

    return lambda size: sample


def race(samplers: list[Sampler], seconds: float) -> list[float]:
    """The least cost of each, called in turn until the time is up; at least one round."""
    end, rounds = time.perf_counter() + seconds, []
    while not rounds or time.perf_counter() < end:
        rounds.append([sample() for sample in samplers])
    return [min(costs) for costs in zip(*rounds, strict=True)]
