"""What the grader asks a kernel before the first and after the last cell: whether the machinery is still the same.

The text of this file is run there as a cell that leaves no name behind.  It prints, in JSON, whose numbers are drawn,
whether a wrong answer is still refused, and a digest of what the checks rely on.
"""


def report(token):
    import builtins
    import importlib
    import json
    import pkgutil
    import sys
    from hashlib import sha256
    from types import CodeType, FunctionType, ModuleType

    import kinlib_assignments
    from kinlib_assignments import student_id
    from kinlib_assignments.checks import assert_equal

    def of_code(code):
        constants = [of_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts if c is not None]
        return [code.co_name, code.co_code.hex(), str(code.co_names), *map(str, sorted(map(str, constants)))]

    def of_thing(thing):
        thing = getattr(thing, "__func__", thing)
        thing = getattr(thing, "fget", None) or thing
        thing = getattr(thing, "__wrapped__", thing)
        return of_code(thing.__code__) if isinstance(thing, FunctionType) else type(thing).__name__

    def of_class(cls):
        return {name: of_thing(value) for name, value in vars(cls).items() if not name.startswith("__abstract")}

    def of_module(module):
        return {
            name: of_class(value) if isinstance(value, type) else of_thing(value)
            for name, value in vars(module).items()
            if (value.__module__ == module.__name__ if isinstance(value, type) else not isinstance(value, ModuleType))
        }

    def of_shell():
        shell = builtins.get_ipython()
        own = [name for name, value in vars(shell).items() if callable(value) and hasattr(type(shell), name)]
        cleanup = [*shell.input_transformers_cleanup, *shell.input_transformers_post]
        return [sorted(own), str(shell.ast_transformers), str(cleanup), of_class(type(shell))]

    def refuses():
        try:
            assert_equal((1, 2), (1, int(token[:4], 16) + 3), token)
        except AssertionError as error:
            return token in str(error)
        return False

    for module in pkgutil.iter_modules(kinlib_assignments.__path__):  # else what is imported later is not compared
        importlib.import_module(f"kinlib_assignments.{module.name}")
    modules = {name: of_module(module) for name, module in sorted(sys.modules.items()) if name.startswith("kinlib")}
    parts = {name: sha256(repr(value).encode()).hexdigest()[:16] for name, value in modules.items()}
    parts["IPython"] = sha256(repr(of_shell()).encode()).hexdigest()[:16]
    kept = {name: id(value) for name, value in vars(builtins).items() if name[0] != "_" and name != "input"}
    parts["Python's own names"] = sha256(repr(sorted(kept.items())).encode()).hexdigest()[:16]
    return json.dumps({"token": token, "student": student_id("?"), "refuses": refuses(), "parts": parts})
