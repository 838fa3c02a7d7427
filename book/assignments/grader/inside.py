"""What the grader asks a kernel before the first, after the last and before each graded cell: is all as it was?

The text of this file is run there as a cell that leaves no name behind.  It prints, in JSON, whose numbers are drawn,
whether a wrong answer is still refused, and a digest of what the checks rely on.
"""

import builtins
import importlib
import json
import pkgutil
import sys
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType

import kinlib
import kinlib_assignments
from kinlib_assignments import student_id
from kinlib_assignments.checks import assert_equal

DRAWING = ("matplotlib", "matplotlib_inline")  # what is called after each cell, so that figures are shown


def report(token):
    for module in pkgutil.iter_modules(kinlib_assignments.__path__):  # else what is imported later is not compared
        importlib.import_module(f"kinlib_assignments.{module.name}")
    for name in kinlib.__all__:  # its files are read when they are asked for
        getattr(kinlib, name)
    ours = {name: module for name, module in sorted(sys.modules.items()) if name.startswith("kinlib")}
    parts = {name: digest(of_module(module)) for name, module in ours.items()}
    parts["IPython"] = digest(of_shell(builtins.get_ipython()))
    kept = {name: id(value) for name, value in vars(builtins).items() if name[0] != "_" and name != "input"}
    parts["Python's own names"] = digest(sorted(kept.items()))
    return json.dumps({"token": token, "student": student_id("?"), "refuses": refuses(token), "parts": parts})


def digest(thing):
    return sha256(repr(thing).encode()).hexdigest()[:16]


def refuses(token):
    """Whether a wrong answer is still refused."""
    try:
        assert_equal((1, 2), (1, int(token[:4], 16) + 3), token)
    except AssertionError as error:
        return token in str(error)
    return False


def of_module(module):
    return {
        name: of_class(value) if isinstance(value, type) else of_thing(value)
        for name, value in vars(module).items()
        if (value.__module__ == module.__name__ if isinstance(value, type) else not isinstance(value, ModuleType))
    }


def of_class(cls):
    return {name: of_thing(value) for name, value in vars(cls).items() if not name.startswith("__abstract")}


def of_thing(thing):
    thing = getattr(thing, "__func__", thing)
    thing = getattr(thing, "fget", None) or thing
    thing = getattr(thing, "__wrapped__", thing)
    return of_code(thing.__code__) if isinstance(thing, FunctionType) else type(thing).__name__


def of_code(code):
    constants = [of_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts if c is not None]
    return [code.co_name, code.co_code.hex(), str(code.co_names), *map(str, sorted(map(str, constants)))]


def of_shell(shell):
    own = [name for name, value in vars(shell).items() if callable(value) and hasattr(type(shell), name)]
    cleanup = [*shell.input_transformers_cleanup, *shell.input_transformers_post]
    called = [function.__module__ or "" for some in shell.events.callbacks.values() for function in some]
    others = [name for name in called if name.split(".")[0] not in ("IPython", "ipykernel", *DRAWING)]
    return [sorted(own), str(shell.ast_transformers), str(cleanup), others, of_class(type(shell))]
