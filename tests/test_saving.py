"""Saved linkages come back bit for bit, and damaged files are refused with words."""

from __future__ import annotations

import json
import math
from fractions import Fraction

import numpy as np
import pytest
import sympy

from kinlib import (
    DualQuaternion,
    Linkage,
    bennett_flip,
    bennett_linkage,
    eps,
    goldberg_linkages,
    i,
    j,
    square_root,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, THREE_POSES
from kinlib.saving import from_json, to_json, write_document
from kinlib.testing import random_poses

THREE = random_poses(3, seed=1)
X = sympy.Symbol("x' \"../\n; import os", real=True)

ROOT = sympy.sqrt(2) * X - sympy.cos(sympy.pi / 7) + sympy.CRootOf(X**5 - X - 1, 0)


def symbolic() -> Linkage:
    h1, h2 = i, 2 * j - 2 * eps * i * X
    return Linkage.from_chains([h1, h2], bennett_flip(h1, h2), parameters=[X, sympy.sqrt(2) * sympy.pi])


def with_nan() -> Linkage:
    linkages = bennett_linkage(*random_poses(3, seed=2, shape=(2,)))
    return Linkage([f * np.array([1.0, math.nan]) for f in linkages.factors], linkages.joints, 2, linkages.home)


LINKAGES = {
    "float": bennett_linkage(*THREE),
    "double joint": goldberg_linkages(*THREE, 0.4 + 0.9j)[0],
    "batch": bennett_linkage(*random_poses(3, seed=2, shape=(2, 3))),
    "NaN": with_nan(),
    "fractions": bennett_linkage(*THREE_POSES),
    "field": bennett_linkage(*FIELD_OF_DEGREE_SIX),
    "symbols": symbolic(),
}


def numbers_of(linkage: Linkage) -> list:
    arrays = [x.coeffs for x in (*linkage.factors, linkage.home)] + [np.asarray(t) for t in linkage.parameters]
    return [(type(x), x) for array in arrays for x in array.ravel()]


@pytest.mark.parametrize("name", LINKAGES)
def test_a_linkage_comes_back_bit_for_bit(name, tmp_path):
    linkage = LINKAGES[name]
    linkage.save(tmp_path / "it.json")
    again = Linkage.load(tmp_path / "it.json")
    assert (again.joints, again.coupler, again.shape) == (linkage.joints, linkage.coupler, linkage.shape)
    assert [type(t) for t in again.parameters] == [type(t) for t in linkage.parameters]
    for (kind, x), (same_kind, y) in zip(numbers_of(again), numbers_of(linkage), strict=True):
        assert kind is same_kind or y.is_Rational  # SymPy gives way to Python when numbers come in
        assert x == y or (x != x and y != y)
        assert math.copysign(1, x) == math.copysign(1, y) if isinstance(x, float) else True
    assert [f.coeffs.dtype for f in again.factors] == [f.coeffs.dtype for f in linkage.factors]
    assert repr(again) == repr(linkage)
    assert [path.name for path in tmp_path.iterdir()] == ["it.json"]


@pytest.mark.parametrize(
    "number",
    [
        3,
        -0.0,
        5e-324,
        1e308,
        math.inf,
        Fraction(-2, 7),
        10**40,
        np.float64(0.1),
        np.float32(0.1),
        square_root(5) / 3,
        ROOT,
    ],
    ids=lambda number: type(number).__name__,
)
def test_a_number_comes_back(number):
    again = from_json(json.loads(json.dumps(to_json(number))))
    assert type(again) is type(number)
    assert again == number
    assert not isinstance(number, float) or math.copysign(1, again) == math.copysign(1, number)


def test_saved_numbers_compute_on():
    field = LINKAGES["field"].factors[0].coeffs
    again = from_json(to_json(field))
    assert all(x - y == 0 for x, y in zip(again, field, strict=True))


def saved(tmp_path, **changes) -> str:
    """A saved linkage with changes to the document; to its content with the checksum of the changed content."""
    path = tmp_path / "changed.json"
    LINKAGES["fractions"].save(path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))
    return path


def test_what_is_damaged_is_refused_with_words(tmp_path):
    path = tmp_path / "it.json"
    LINKAGES["float"].save(path)
    text = path.read_text()
    for damaged in (text[: len(text) // 2], "", "[]", '{"kinlib": "table"}', "\x00"):
        path.write_text(damaged)
        with pytest.raises(ValueError, match="this is no saved linkage"):
            Linkage.load(path)
    digit = next(n for n in range(len(text) // 2, len(text)) if text[n] in "12345678")
    path.write_text(text[:digit] + "9" + text[digit + 1 :])
    with pytest.raises(ValueError, match="the file was changed since the linkage was saved"):
        Linkage.load(path)
    with pytest.raises(ValueError, match="the file has version 99; this kinlib reads versions up to 1: update kinlib"):
        Linkage.load(saved(tmp_path, version=99))
    with pytest.raises(FileNotFoundError):
        Linkage.load(tmp_path / "nothing.json")


@pytest.mark.parametrize(
    "change",
    [
        {"joints": [1, 1]},
        {"coupler": "2"},
        {"home": {"array": ["__import__('os')"], "dtype": "|O", "shape": [1]}},
        {"home": {"dual quaternion": {"array": [1], "dtype": "|O", "shape": [1]}}},
        {"parameters": [{"sympy": {"__import__": ["os"]}}]},
        {"extra": 1},
    ],
    ids=str,
)
def test_what_has_a_checksum_but_is_no_linkage_is_refused(change, tmp_path):
    content = json.loads(saved(tmp_path).read_text())["content"]
    write_document(tmp_path / "wrong.json", "linkage", {**content, **change})
    with pytest.raises(ValueError, match="the file does not hold a linkage"):
        Linkage.load(tmp_path / "wrong.json")


def test_what_does_not_close_is_not_loaded(tmp_path):
    content = json.loads(saved(tmp_path).read_text())["content"]
    content["factors"][0] = to_json(DualQuaternion([0, 0, 1, 0, 0, 0, 0, 0]))
    write_document(tmp_path / "open.json", "linkage", content)
    with pytest.raises(ValueError, match="the loop does not close"):
        Linkage.load(tmp_path / "open.json")


def test_numbers_that_can_not_be_saved_are_refused(tmp_path):
    _, x = sympy.ring("x", sympy.QQ)
    with pytest.raises(TypeError, match="expected numbers of Python, NumPy, SymPy or a number field to save"):
        to_json(x)
    with pytest.raises(TypeError, match=r"(?s)can not be saved: .* with Integral"):
        to_json(sympy.Integral(X, X))
    with pytest.raises(TypeError, match="expected numbers to save"):
        to_json(True)


def test_a_failed_save_leaves_the_old_file(tmp_path):
    path = tmp_path / "it.json"
    LINKAGES["float"].save(path)
    before = path.read_bytes()
    with pytest.raises(FileNotFoundError):
        LINKAGES["float"].save(tmp_path / "no such folder" / "it.json")
    assert path.read_bytes() == before
