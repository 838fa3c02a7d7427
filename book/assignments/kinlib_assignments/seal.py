"""Checks that somebody has changed are no checks: what is changed is found, and named."""

from __future__ import annotations

import builtins
import inspect
import sys
from collections.abc import Callable, Iterator
from types import CodeType, ModuleType

import numpy as np

__all__ = ["assert_untouched", "on_other_numbers", "seal"]

OTHERS = ("hidden first", "hidden second", "hidden third")
"""The names of students who do not exist; their numbers are the other ones."""

EXCHANGED = {"breakpoint", "display", "exit", "get_ipython", "help", "input", "open", "print", "quit"}
"""What Jupyter exchanges in Python itself."""

_SEALED: dict[tuple[str, str], tuple[object, CodeType | None]] = {}


def seal() -> None:
    """Remember all that kinlib, the assignments, NumPy and Python itself offer now.

    Each assignment does so when it is imported, before a student's first answer.
    """
    for name, thing in _offered():
        _SEALED.setdefault(name, (thing, _code(thing)))


def assert_untouched() -> None:
    """Fail if something that was remembered is another now.

    Examples
    --------
    >>> seal()
    >>> assert_untouched()
    """
    now = dict(_offered())
    changed = [
        ".".join(name)
        for name, (thing, code) in _SEALED.items()
        if now.get(name) is not thing or _code(thing) is not code
    ]
    if changed:
        raise AssertionError(f"no points, since this notebook replaced what the checks need: {', '.join(changed[:3])}")


def _offered() -> Iterator[tuple[tuple[str, str], object]]:
    """All that is looked at, by where it is and its name."""
    for module in (builtins, np):
        public = (
            (name, thing) for name, thing in list(vars(module).items()) if name[0] != "_" and name not in EXCHANGED
        )
        yield from (((module.__name__, name), thing) for name, thing in public)
    yield ("builtins", "__import__"), builtins.__import__
    for owner in (*_modules(), *_classes()):
        where = owner.__name__ if isinstance(owner, ModuleType) else f"{owner.__module__}.{owner.__qualname__}"
        yield from (((where, name), thing) for name, thing in list(vars(owner).items()))


def _modules() -> list[ModuleType]:
    return [module for name, module in list(sys.modules.items()) if _is_ours(name) and isinstance(module, ModuleType)]


def _is_ours(name: str) -> bool:
    return name.split(".")[0] in ("kinlib", "kinlib_assignments")


def _classes() -> list[type]:
    found = (thing for module in _modules() for thing in list(vars(module).values()) if inspect.isclass(thing))
    return list({id(kind): kind for kind in found if _is_ours(kind.__module__)}.values())


def _code(thing: object) -> CodeType | None:
    """The code of a function, whatever it is wrapped in."""
    if isinstance(thing, staticmethod | classmethod):
        thing = thing.__func__
    if isinstance(thing, property):
        thing = thing.fget
    thing = getattr(thing, "__wrapped__", thing)  # in a cache
    return thing.__code__ if inspect.isfunction(thing) else None


def _forget() -> None:
    """Empty all caches of kinlib and the assignments: what is in them may have been worked out by something else."""
    for module in _modules():
        for thing in list(vars(module).values()):
            if hasattr(thing, "cache_clear") and not inspect.isclass(thing):
                thing.cache_clear()


def on_other_numbers(check: Callable[..., None], *answers) -> None:
    """The check of a student's answers, on numbers of others: what is right for one's own only is found out.

    Examples
    --------
    >>> from kinlib_assignments.dual_quaternions import check_counterexample
    >>> i, j = [0, 1, 0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0, 0, 0]
    >>> on_other_numbers(check_counterexample, (i, j))
    >>> on_other_numbers(check_counterexample, (i, i))
    Traceback (most recent call last):
        ...
    AssertionError: with other numbers than yours: the counterexample: these two commute, so the order does not matter
    """
    assert_untouched()
    _forget()
    _on_others(check, *answers)


def _on_others(check: Callable[..., None], *answers) -> None:
    for name in OTHERS:
        try:
            check(*answers, name)
        except AssertionError as error:
            raise AssertionError(f"with other numbers than yours: {error}") from error
