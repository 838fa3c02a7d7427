"""Functions of kinlib that are the answer to a question are withheld while a student's function works."""

from __future__ import annotations

import inspect
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import PurePath
from types import CodeType, FrameType, FunctionType

__all__ = ["answer_of", "defined_beside", "methods_of", "withheld"]


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


def methods_of(kind: type) -> tuple[FunctionType, ...]:
    """All functions of a class: its methods, class methods and properties.

    Examples
    --------
    >>> from kinlib import ZPlane
    >>> {ZPlane.partner, ZPlane.of.__func__, ZPlane.corners.fget} <= set(methods_of(ZPlane))
    True
    """
    things = [getattr(thing, "__func__", getattr(thing, "fget", thing)) for thing in vars(kind).values()]
    return tuple(thing for thing in things if inspect.isfunction(thing))


def answer_of(function: Callable, *given, without: tuple[FunctionType, ...] = ()):
    """What a student's function gives, while some functions are withheld; a generator is run to its end.

    Examples
    --------
    >>> from kinlib import factorize
    >>> answer_of(lambda x: (x + n for n in range(3)), 1, without=(factorize,))
    [1, 2, 3]
    """
    if not callable(function):
        raise AssertionError(
            f"a function is asked for, but there is {function!r}: was its name used for something else?"
        )
    with withheld(*without):
        answer = function(*given)
        return list(answer) if hasattr(answer, "__next__") else answer


@contextmanager
def withheld(*functions: FunctionType) -> Iterator[None]:
    """While this context lasts, the functions fail, by whatever name they are called.

    It is their code that is exchanged, so that a reference taken before does not help.  Nor does a copy of their code
    or a second import of their file: it is recognised when it runs.  No other program can be asked meanwhile.

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
    functions = tuple(dict.fromkeys(functions))
    kept = [(f, f.__code__, f.__defaults__, f.__kwdefaults__) for f in functions]
    watch = _Watch(functions)
    try:
        for function in functions:
            function.__code__ = _refusal(function)
            function.__defaults__ = function.__kwdefaults__ = None
        with watch.on_duty():
            yield
    finally:
        for function, *parts in kept:
            function.__code__, function.__defaults__, function.__kwdefaults__ = parts
    if watch.seen:  # a refusal that the answer caught
        raise AssertionError(watch.seen[0])


def _says(function: FunctionType) -> str:
    return f"{function.__qualname__} of kinlib is the answer itself: write your own"


@cache
def _refusal(function: FunctionType) -> CodeType:
    """The code of a function that takes anything and says why it does nothing."""
    made: dict = {}
    exec(f"def refuse(*args, **options):\n    raise AssertionError({_says(function)!r})", made)
    return made["refuse"].__code__.replace(co_freevars=function.__code__.co_freevars)  # Python asks for as many


class _Watch:
    """Looks at each function that begins to run, and refuses copies of what is withheld."""

    def __init__(self, functions: tuple[FunctionType, ...]):
        self._known = {_body(f.__code__): _says(f) for f in functions if f.__code__.co_filename.endswith(".py")}
        self._files = {file for file, *_ in self._known}
        self._looked_at: dict[int, tuple[CodeType, str | None]] = {}
        self.seen: list[str] = []

    @contextmanager
    def on_duty(self) -> Iterator[None]:
        before = sys.getprofile()
        sys.setprofile(self._look)
        threading.setprofile(self._look)
        _ON_DUTY.append(self)
        try:
            yield
        finally:
            _ON_DUTY.remove(self)
            threading.setprofile(None)
            sys.setprofile(before)

    def _look(self, frame: FrameType, event: str, _) -> None:
        if event == "call" and (said := self._refused(frame.f_code)):
            self.refuse(said)

    def _refused(self, code: CodeType) -> str | None:
        if id(code) not in self._looked_at:  # the code is kept, so that nothing else gets its id
            self._looked_at[id(code)] = code, self._known.get(_body(code)) if _file(code) in self._files else None
        return self._looked_at[id(code)][1]

    def refuse(self, said: str) -> None:
        self.seen.append(said)
        raise AssertionError(said)


def _file(code: CodeType) -> tuple[str, ...]:
    """Folder and name of the file of some code, wherever a copy of it is."""
    return PurePath(code.co_filename).parts[-2:]


def _body(code: CodeType) -> tuple:
    return _file(code), code.co_name, code.co_code


# ---- other programs --------------------------------------------------------------------------------------

OTHER_PROGRAMS = {
    "os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn", "os.system", "pty.spawn", "socket.connect",
    "subprocess.Popen",
}  # fmt: skip

_ON_DUTY: list[_Watch] = []


def _hear(event: str, _) -> None:
    """Python tells of each of these events; what hears them cannot be taken away again."""
    if _ON_DUTY and event in OTHER_PROGRAMS:
        _ON_DUTY[-1].refuse("an answer must not ask another program")


sys.addaudithook(_hear)
