"""Functions of kinlib that are the answer to a question are withheld while the answer is marked."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import CodeType, FunctionType

__all__ = ["defined_beside", "withheld"]


def defined_beside(*known: Callable) -> tuple[FunctionType, ...]:
    """All functions of the files in which some functions or classes of kinlib are defined, their own included.

    Examples
    --------
    >>> from kinlib import act, translation
    >>> translation in defined_beside(act)
    True
    """
    files = {one.__module__: sys.modules[one.__module__] for one in known}
    functions = (thing for file in files.values() for thing in vars(file).values() if inspect.isfunction(thing))
    return tuple(function for function in functions if function.__module__ in files)


@contextmanager
def withheld(*functions: FunctionType) -> Iterator[None]:
    """While this context lasts, the functions fail, by whatever name they are called.

    It is their code that is exchanged, so that a reference taken before does not help.

    Parameters
    ----------
    functions : functions or methods of kinlib, as ``kinlib.factorize`` or ``DualQuaternion.conjugate``

    Examples
    --------
    >>> import kinlib
    >>> mine = kinlib.factorize
    >>> with withheld(kinlib.factorize):
    ...     mine(1)
    Traceback (most recent call last):
        ...
    AssertionError: factorize of kinlib is the answer itself: write your own
    """
    kept = [(f, f.__code__, f.__defaults__, f.__kwdefaults__) for f in functions]
    try:
        for function in functions:
            function.__code__ = _refusal(function)
            function.__defaults__ = function.__kwdefaults__ = None
        yield
    finally:
        for function, *parts in kept:
            function.__code__, function.__defaults__, function.__kwdefaults__ = parts


def _refusal(function: FunctionType) -> CodeType:
    """The code of a function that takes anything and says why it does nothing."""
    message = f"{function.__qualname__} of kinlib is the answer itself: write your own"
    made: dict = {}
    exec(f"def refuse(*args, **options):\n    raise AssertionError({message!r})", made)
    return made["refuse"].__code__.replace(co_freevars=function.__code__.co_freevars)  # Python asks for as many
