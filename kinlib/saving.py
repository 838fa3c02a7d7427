"""Numbers of every kind as JSON and back, bit for bit; and whole files that say what they are and refuse damage.

Nothing that is read is executed: expressions of SymPy are trees of a few known kinds.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.number_field import NumberField, NumberFieldElement

__all__ = ["from_json", "read_document", "to_json", "write_document"]

VERSION = 1
"""Of the files that are written; older ones can be read, newer ones are refused."""


# ---- files -------------------------------------------------------------------------------------------


def write_document(path: str | os.PathLike[str], kind: str, content: dict[str, Any]) -> None:
    """Write a file that says what it is; it is whole or it is not there.

    Parameters
    ----------
    path : str or path
    kind : str
        What is saved, such as "linkage".
    content : dict
        Of values that :func:`to_json` gives.
    """
    document = {"kinlib": kind, "version": VERSION, "sha256": _digest(content), "content": content}
    target = Path(path)
    new = target.with_name(f"{target.name}.{os.getpid()}.new")
    try:
        new.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        new.replace(target)
    finally:
        new.unlink(missing_ok=True)


def read_document(path: str | os.PathLike[str], kind: str) -> dict[str, Any]:
    """The content of a file that was written by :func:`write_document`.

    Raises
    ------
    ValueError
        If it is no such file, of another kind, of a newer version, or was changed since it was written.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"this is no saved {kind}: the file is damaged or of another kind ({error})") from None
    if not isinstance(document, dict) or document.get("kinlib") != kind:
        found = document.get("kinlib") if isinstance(document, dict) else None
        raise ValueError(f"this is no saved {kind}" + (f" but a saved {found}" if isinstance(found, str) else ""))
    version = document.get("version")
    if not isinstance(version, int) or version > VERSION:
        raise ValueError(f"the file has version {version!r}; this kinlib reads versions up to {VERSION}: update kinlib")
    content = document.get("content")
    if not isinstance(content, dict) or document.get("sha256") != _digest(content):
        raise ValueError(f"the file was changed since the {kind} was saved: its content does not have its checksum")
    return content


def _digest(content: dict[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


# ---- values ------------------------------------------------------------------------------------------


def to_json(value: Any) -> Any:
    """A number, an array, a dual quaternion or a tuple of them as what JSON knows.

    Raises
    ------
    TypeError
        If there is a number that can not be saved.

    Examples
    --------
    >>> from kinlib import square_root
    >>> to_json(Fraction(1, 3)), to_json(math.inf), to_json(0.1)
    ({'fraction': '1/3'}, {'float': 'inf'}, 0.1)
    >>> to_json(square_root(2))
    {'field': {'pow': [2, {'fraction': '1/2'}]}, 'coefficients': ['1', '0']}
    """
    if isinstance(value, DualQuaternion):
        return {"dual quaternion": to_json(value.coeffs)}
    if isinstance(value, (tuple, list)):
        return [to_json(x) for x in value]
    if isinstance(value, (np.ndarray, np.generic)):
        array = np.asarray(value)
        entries = [to_json(x if array.dtype.kind == "O" else x.item()) for x in array.ravel()]
        return {"array": entries, "dtype": array.dtype.str, "shape": list(array.shape)}
    return _number_to_json(value)


def _number_to_json(x: Any) -> Any:
    if isinstance(x, bool):
        raise TypeError(f"expected numbers to save, got {x!r}")
    if isinstance(x, float):
        return x if math.isfinite(x) else {"float": repr(x)}
    if isinstance(x, int):
        return x
    if isinstance(x, Fraction):
        return {"fraction": str(x)}
    if isinstance(x, NumberFieldElement):
        return {"field": _expression_to_json(x.field.root), "coefficients": [str(c) for c in x.coefficients]}
    if hasattr(x, "free_symbols"):
        return {"sympy": _expression_to_json(x)}
    raise TypeError(f"expected numbers of Python, NumPy, SymPy or a number field to save, got {type(x).__name__} {x!r}")


def from_json(value: Any) -> Any:
    """What :func:`to_json` was given; lists become tuples.

    Raises
    ------
    ValueError, TypeError, KeyError
        If it is none of what :func:`to_json` gives.

    Examples
    --------
    >>> from_json(to_json((1, Fraction(1, 3), math.inf)))
    (1, Fraction(1, 3), inf)
    """
    if isinstance(value, list):
        return tuple(from_json(x) for x in value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return value
    if not isinstance(value, dict):
        raise ValueError(f"expected a number, got {value!r}")
    if "dual quaternion" in value:
        return DualQuaternion(from_json(value["dual quaternion"]))
    if "array" in value:
        return _array_from_json(value)
    if "float" in value:
        return float(value["float"])
    if "fraction" in value:
        return Fraction(value["fraction"])
    if "field" in value:
        field = NumberField(_expression_from_json(value["field"]))
        return field.element([Fraction(c) for c in value["coefficients"]])
    return _expression_from_json(value["sympy"])


def _array_from_json(value: dict[str, Any]) -> Any:
    dtype, shape = np.dtype(value["dtype"]), tuple(value["shape"])
    if dtype.kind not in "fO":
        raise ValueError(f"expected real or exact numbers, got an array of {dtype}")
    array = np.empty(len(value["array"]), dtype=dtype)
    for n, x in enumerate(value["array"]):
        array[n] = from_json(x)
    return array.reshape(shape)[()]


# ---- expressions of SymPy ----------------------------------------------------------------------------

FUNCTIONS = ("Add", "Mul", "Pow", "sin", "cos", "tan", "cot", "asin", "acos", "atan", "atan2", "exp", "log", "Abs")
CONSTANTS = ("pi", "E", "I")


def _expression_to_json(x: Any) -> Any:
    """An expression as a tree; refused unless the tree gives it back."""
    tree = _tree(x)
    if _expression_from_json(tree) != x:
        raise TypeError(f"this expression can not be saved: {x}")
    return tree


def _tree(x: Any) -> Any:
    import sympy

    if x.is_Integer:
        return int(x)
    if x.is_Rational:
        return {"fraction": f"{x.p}/{x.q}"}
    if x.is_Symbol:
        return {"symbol": x.name, "assumptions": dict(sorted(x._assumptions_orig.items()))}
    if isinstance(x, sympy.CRootOf):
        return {"root": [int(c) for c in x.poly.all_coeffs()], "number": int(x.index)}
    constant = next((name for name in CONSTANTS if x == getattr(sympy, name)), None)
    if constant:
        return {"constant": constant}
    name = type(x).__name__
    if name not in FUNCTIONS:
        raise TypeError(f"this expression can not be saved: {x}, with {name}")
    return {name.lower(): [_tree(arg) for arg in x.args]}


def _expression_from_json(tree: Any) -> Any:
    import sympy

    if isinstance(tree, int) and not isinstance(tree, bool):
        return sympy.Integer(tree)
    if not isinstance(tree, dict):
        raise ValueError(f"expected an expression, got {tree!r}")
    if "fraction" in tree:
        value = Fraction(tree["fraction"])
        return sympy.Rational(value.numerator, value.denominator)
    if "symbol" in tree:
        assumptions = {str(name): bool(holds) for name, holds in tree["assumptions"].items()}
        return sympy.Symbol(str(tree["symbol"]), **assumptions)
    if "root" in tree:
        polynomial = sympy.Poly([int(c) for c in tree["root"]], sympy.Symbol("x"))
        return sympy.CRootOf(polynomial, int(tree["number"]))
    if "constant" in tree:
        return getattr(sympy, CONSTANTS[CONSTANTS.index(tree["constant"])])
    ((name, args),) = tree.items()
    functions = {function.lower(): function for function in FUNCTIONS}
    return getattr(sympy, functions[name])(*[_expression_from_json(arg) for arg in args])
