"""Functions of kinlib that are the answer to a question are withheld while the answer is marked."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import FunctionType

__all__ = ["withheld"]


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
            function.__code__ = _refusal(function).__code__
            function.__defaults__ = function.__kwdefaults__ = None
        yield
    finally:
        for function, *parts in kept:
            function.__code__, function.__defaults__, function.__kwdefaults__ = parts


def _refusal(function: FunctionType) -> FunctionType:
    """A function that takes anything and says why it does nothing."""
    message = f"{function.__qualname__} of kinlib is the answer itself: write your own"
    made: dict = {}
    exec(f"def refuse(*args, **options):\n    raise AssertionError({message!r})", made)
    return made["refuse"]
