"""Displacements: SciPy agrees about order and signs, and points and lines move together."""

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Line,
    act,
    as_float,
    as_matrix,
    as_pose,
    as_rigid_transform,
    axis_of,
    eps,
    from_matrix,
    from_rigid_transform,
    half_turn,
    i,
    j,
    k,
    one,
    rotation,
    same_point,
    square_root,
    translation,
    unit,
)
from kinlib.testing import random_poses
from strategies import fraction_vectors, fractions, lines, poses, rotations, vectors, whole

a = square_root(2)
x, y = sympy.symbols("x y", real=True)
z_axis = Line([0, 0, 1], [0, 0, 0])


def scipy_rotation(line: Line, angle: float) -> RigidTransform:
    """The turn about a line as SciPy composes it: move the line to the origin, turn, move back."""
    direction = np.array(line.direction, dtype=float)
    foot = np.array(line.foot(), dtype=float)
    turn = RigidTransform.from_rotation(Rotation.from_rotvec(angle * direction / np.linalg.norm(direction)))
    return RigidTransform.from_translation(foot) * turn * RigidTransform.from_translation(-foot)


def random_transforms(count: int, seed: int) -> RigidTransform:
    random = np.random.default_rng(seed)
    rotations = Rotation.from_quat(random.normal(size=(count, 4)))
    return RigidTransform.from_components(random.normal(size=(count, 3)), rotations)


# SciPy as second source


@given(vectors)
def test_translations_are_those_of_scipy(v):
    assert np.array(as_matrix(translation(v)), dtype=float) == pytest.approx(
        RigidTransform.from_translation(v).as_matrix()
    )


@given(lines(), st.floats(-6, 6))
def test_rotations_are_those_of_scipy(line, angle):
    ours = as_matrix(rotation(line, angle))
    assert ours == pytest.approx(scipy_rotation(line, angle).as_matrix(), abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_products_are_compositions(seed):
    S, T = random_transforms(2, seed)
    product = from_rigid_transform(S) * from_rigid_transform(T)
    assert as_matrix(product) == pytest.approx((S * T).as_matrix())
    assert as_rigid_transform(product).as_matrix() == pytest.approx((S * T).as_matrix())


@pytest.mark.parametrize("seed", range(5))
def test_points_move_as_scipy_moves_them(seed):
    T = random_transforms(1, seed)[0]
    points = np.random.default_rng(seed).normal(size=(10, 3))
    assert act(from_rigid_transform(T), points) == pytest.approx(T.apply(points))


def test_a_batch_of_transforms():
    S = random_transforms(7, 0)
    q = from_rigid_transform(S)
    assert q.shape == (7,)
    assert as_matrix(q) == pytest.approx(S.as_matrix())
    assert as_matrix(q.inverse()) == pytest.approx(S.inv().as_matrix())
    assert as_rigid_transform(q).as_matrix() == pytest.approx(S.as_matrix())


# The action, exactly


@given(poses(), poses(), fraction_vectors)
def test_the_right_factor_acts_first(q, r, point):
    assert (act(q * r, point) == act(q, act(r, point))).all()


@given(poses(), poses())
def test_matrices_multiply_as_poses_do(q, r):
    assert (as_matrix(q * r) == as_matrix(q) @ as_matrix(r)).all()
    assert (as_matrix(q.inverse()) @ as_matrix(q) == np.eye(4)).all()


@given(poses(), fractions.filter(bool), fraction_vectors)
def test_multiples_of_a_pose_act_alike(q, factor, point):
    assert (act(factor * q, point) == act(q, point)).all()


@given(poses(), vectors)
def test_the_action_is_equation_1(q, point):
    """[x] ↦ [(p + εd) x (p̄ − εd̄)] with x = 1 + εx."""
    moved = q * DualQuaternion([1, 0, 0, 0, 0, *point]) * q.eps_conjugate().conjugate()
    assert same_point(moved, DualQuaternion([1, 0, 0, 0, 0, *act(q, point)]))


@given(poses(), vectors, vectors)
def test_distances_and_orientation_are_kept(q, u, v):
    origin, p, r = (act(q, point) for point in ([0, 0, 0], u, v))
    p, r = p - origin, r - origin
    assert p @ r == np.dot(u, v)
    assert (np.cross(p, r) == act(q.primal, np.cross(u, v))).all()


@given(poses(), lines(), fractions)
def test_points_of_a_line_move_with_it(q, line, s):
    point = line.foot() + s * line.direction
    moved = act(q, line)
    assert moved.contains(act(q, point))
    assert (moved.direction == act(q, point + line.direction) - act(q, point)).all()


@given(poses(), lines())
def test_lines_move_by_conjugation(q, line):
    h = line.as_dual_quaternion()
    assert act(q, line).as_dual_quaternion() == q * h * q.inverse()


@given(vectors, vectors, fraction_vectors)
def test_translations_add(u, v, point):
    assert translation(u) * translation(v) == translation(np.add(u, v))
    assert (act(translation(u), point) == np.add(point, u)).all()


@given(lines(), fractions, vectors)
def test_a_rotation_fixes_its_axis(line, s, point):
    q = s - line.as_dual_quaternion()
    axis_point = line.foot() + s * line.direction
    assert (act(q, axis_point) == axis_point).all()
    moved = act(q, point)
    assert (moved - point) @ line.direction == 0
    assert (moved - axis_point) @ (moved - axis_point) == (point - axis_point) @ (point - axis_point)


@given(lines(), vectors)
def test_half_turns(line, point):
    h = half_turn(line)
    moved = act(h, point)
    assert (moved + point == 2 * line.foot(point)).all()
    assert same_point(h * h, one)


def test_the_sense_of_a_rotation():
    quarter = rotation(z_axis, math.pi / 2)
    assert act(quarter, [1, 0, 0]) == pytest.approx([0, 1, 0])
    assert act(1 + k, [1, 0, 0]).tolist() == [0, 1, 0]
    assert act(1 - k, [1, 0, 0]).tolist() == [0, -1, 0]


@given(lines(), st.floats(-3, 3), st.floats(-3, 3))
def test_angles_add(line, angle, other):
    product = rotation(line, angle) * rotation(line, other)
    assert product.coeffs == pytest.approx(rotation(line, angle + other).coeffs, abs=1e-9)


def test_angles_add_in_symbols():
    assert rotation(z_axis, x) * rotation(z_axis, -x) == 1
    point = act(rotation(z_axis, x), [1, 0, 0])
    assert [sympy.simplify(c - d) for c, d in zip(point, (sympy.cos(x), sympy.sin(x), 0), strict=True)] == [0, 0, 0]


@pytest.mark.parametrize("direction", [[1, 1, 0], [1.0, 1.0, 0], [a, a, 0], [Fraction(1, 3), Fraction(1, 3), 0]])
@pytest.mark.parametrize("angle", [0.5, 1, Fraction(1, 2)])
def test_the_length_of_the_direction_does_not_matter(direction, angle):
    line = Line.at([1, 2, 3], direction)
    expected = scipy_rotation(Line.at([1, 2, 3], [1, 1, 0]), float(angle)).as_matrix()
    assert as_matrix(rotation(line, angle)) == pytest.approx(expected)


def test_exact_angles_about_irrational_directions():
    q = rotation(Line([1, 1, 1], [0, 0, 0]), 2 * sympy.pi / 3)
    assert q == (1 + i + j + k) / 2
    assert act(q, [1, 2, 3]).tolist() == [3, 1, 2]


def test_many_angles_and_many_lines():
    angles = np.linspace(-3, 3, 5)
    sheaf = Line.at(np.arange(15.0).reshape(5, 3), [1, 2, 2])
    for line in (Line.at([1, 2, 3], [1, 2, 2]), sheaf):
        turned = act(rotation(line, angles), [1, 0, 0])
        assert turned.shape == (5, 3)
    assert turned[2] == pytest.approx([1, 0, 0])
    single = Line(sheaf.direction[4], sheaf.moment[4])
    assert turned[4] == pytest.approx(scipy_rotation(single, angles[4]).apply([1, 0, 0]))


# Other scalars


@pytest.mark.parametrize("number", [2, Fraction(1, 3), a, x])
def test_every_scalar_moves_points(number):
    """Turning by 1 + n i, written out for the points (1, n, 0)."""
    square = 1 + number * number
    turned = np.array([1, number * (1 - number * number), 2 * number * number])
    moved = act(translation([number, 0, 1]) * (1 + number * i), [1, number, 0])
    gap = moved * square - turned - np.array([number * square, 0, square]) - [square - 1, 0, 0]
    assert all(sympy.simplify(c) == 0 if number is x else c == 0 for c in gap)


def test_exact_poses_stay_exact():
    matrix = as_matrix(translation([1, 2, 3]) * (1 + 2 * i + 2 * j))
    assert all(isinstance(c, (int, Fraction)) for c in matrix.ravel())
    assert as_matrix(1 + a * i)[1, 1] == Fraction(-1, 3)
    assert as_matrix(1 + a * i)[2, 1] == 2 * a / 3


@pytest.mark.parametrize("q", [1 + i, DualQuaternion.stack([1 + i, 1 + i, 1 + i])])
def test_exact_poses_move_floats_to_floats(q):
    assert act(q, np.array([0.5, 1, 2])).dtype == float
    assert act(q, np.array([0.5, 1, 2])).reshape(-1, 3)[0] == pytest.approx([0.5, -2, 1])
    assert act(q, Line([0.5, 1, 2], [0, 0, 0])).direction.dtype == float


def test_batches_of_poses_and_points_broadcast():
    q = DualQuaternion.stack(random_poses(4, seed=1))
    points = np.random.default_rng(0).normal(size=(4, 3))
    assert act(q, points)[2] == pytest.approx(act(q[2], points[2]))
    assert act(q[:, None], points)[1, 3] == pytest.approx(act(q[1], points[3]))
    assert act(q, points[0])[3] == pytest.approx(act(q[3], points[0]))
    assert as_matrix(q)[1] == pytest.approx(as_matrix(q[1]))
    assert from_matrix(as_matrix(q[:, None])).shape == (4, 1)
    line = act(q, Line.at(points, points[::-1]))
    assert line.contains(act(q, points)).all()


# Matrices back to poses


@given(poses())
def test_the_pose_of_a_matrix(q):
    assert same_point(from_matrix(as_matrix(q)), q)


@given(rotations())
def test_the_pose_of_the_matrix_of_a_rotation(q):
    again = from_matrix(as_matrix(q))
    assert same_point(again, q)
    assert not any(isinstance(c, float) for c in again.coeffs)


@pytest.mark.parametrize("q", [one, i, j, k, 1 + i + j + k, i + j, 1 - 2 * k, i - 3 * k, a * i + j])
def test_every_component_may_be_the_largest_or_vanish(q):
    pose = translation([1, -2, 3]) * q
    assert same_point(from_matrix(as_matrix(pose)), pose)
    assert same_point(from_matrix(np.array(as_matrix(pose), dtype=float)), pose)


def test_floats_give_unit_poses():
    q = from_matrix(random_transforms(20, 3).as_matrix())
    assert q.norm().coeffs == pytest.approx(np.eye(8)[[0] * 20])


def test_a_batch_of_exact_matrices_stays_exact():
    turned = translation([1, 0, 0]) * (3 + 4 * k)
    batch = from_matrix(np.stack([np.eye(4, dtype=int), as_matrix(i + j), as_matrix(turned)]))
    assert same_point(batch, DualQuaternion.stack([one, i + j, turned])).all()
    assert not any(isinstance(c, float) for c in batch.coeffs.ravel())


@pytest.mark.parametrize("turn", [1e-3, 1e-6, 1e-9, math.pi - 1e-9, math.pi])
@pytest.mark.parametrize("length", [1e-3, 1.0, 1e6])
def test_small_turns_and_long_ways(turn, length):
    q = translation([length, -length, 2 * length]) * rotation(Line.at([length, 0, 0], [1, 2, 2]), turn)
    again = from_matrix(as_matrix(q))
    assert same_point(again, q, length=length, rtol=1e-12)
    vector = again.coeffs[1:4] * np.sign(again.coeffs[0] or 1)
    assert 2 * np.arcsin(min(np.linalg.norm(vector), 1)) == pytest.approx(turn, rel=1e-7)


# Units and axes


@pytest.mark.parametrize(
    ("q", "expected"),
    [
        (3 * i + 4 * j, (3 * i + 4 * j) / 5),
        (2 * i + 2 * eps * j, i + eps * j),
        (i + j, i + j),  # of length √2: left as it is
        ((3.0 * i + 4 * j), 0.6 * i + 0.8 * j),
        (a * i, i),
        (DualQuaternion.stack([3 * i + 4 * j, i + j]), DualQuaternion.stack([(3 * i + 4 * j) / 5, i + j])),
    ],
)
def test_units_without_leaving_the_field(q, expected):
    assert np.all(unit(q) == expected) or unit(q).coeffs == pytest.approx(expected.coeffs)
    assert np.all(same_point(unit(q), q))


@given(rotations(), whole)
def test_the_axis_of_a_rotation(q, n):
    axis = axis_of(q)
    line = Line.from_dual_quaternion(axis)
    assert same_point(axis, q - q.conjugate())
    assert all((act(q, line.foot() + s * line.direction) == line.foot() + s * line.direction).all() for s in (0, n))


def test_rounding_is_taken_off_an_axis():
    h = rotation(Line.at([1.0, 2, 3], [1, 2, 2]), 1.0) + 1e-9 * eps * i
    axis = axis_of(h)
    assert axis.norm().coeffs == pytest.approx(np.eye(8)[0], abs=1e-15)


@pytest.mark.parametrize("q", [one, translation([1, 0, 0]), translation([1.0, 0, 0])])
def test_translations_have_no_axis(q):
    with pytest.raises(DegenerateError, match="no axis"):
        axis_of(q)


# What is a pose and what is not


def test_poses_come_in_three_forms():
    q = translation([1, 2, 3]) * (1 + 2 * i + 2 * j)
    assert as_pose(q) == q
    assert same_point(as_pose(as_matrix(q)), q)
    assert same_point(as_pose(as_matrix(q).tolist()), q)
    assert same_point(as_pose(as_rigid_transform(q)), q)
    assert as_pose(random_transforms(3, 0)).shape == (3,)


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e6])
def test_points_off_the_study_quadric_are_no_poses(length):
    q = translation([length, 0.0, 0])
    assert as_pose(q) == q
    with pytest.raises(ValueError, match="expected a point of the Study quadric"):
        as_pose(q + 1e-6 * length * eps)
    with pytest.raises(ValueError, match="expected a point of the Study quadric"):
        as_pose(DualQuaternion.stack([one, 1 + eps]))


@pytest.mark.parametrize("q", [eps, eps * i, 0 * one, 0.0 * one, DualQuaternion.stack([one, eps])])
def test_points_of_the_exceptional_space_are_no_poses(q):
    for use in (as_pose, as_matrix, lambda q: act(q, [1, 0, 0]), lambda q: act(q, z_axis)):
        with pytest.raises(DegenerateError, match="exceptional three-space"):
            use(q)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_poses_are_finite(number):
    matrix = np.eye(4)
    matrix[0, 3] = number
    for pose in (matrix, DualQuaternion([1, 0, 0, 0, 0, number, 0, 0])):
        with pytest.raises(ValueError, match="expected finite"):
            as_pose(pose)
    with pytest.raises(ValueError, match="expected finite"):
        from_matrix(matrix)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1, 1, -1, 1]), "expected a rotation"),
        (np.diag([2, 1, 1, 1]), "expected a rotation"),
        (np.diag([1, 1, 1 + 1e-6, 1]), "expected a rotation"),
        (np.zeros((4, 4)), "expected a rotation"),
        (np.stack([np.eye(4), np.diag([1, 1, -1, 1])]), "expected a rotation"),
        (np.diag([1, 1, 1, 2]), "expected the last row"),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 1]], "expected the last row"),
        (np.eye(3), "of shape"),
        (np.ones(8), "of shape"),
    ],
)
def test_matrices_of_no_displacement(matrix, message):
    with pytest.raises(ValueError, match=message):
        from_matrix(matrix)


@pytest.mark.parametrize("wrong", [5, [5], [1, 2], [1, 2, 3, 4], [[1], [2]]])
def test_vectors_have_three_coordinates(wrong):
    with pytest.raises(ValueError, match=r"of shape \(\.\.\., 3\)"):
        translation(wrong)
    with pytest.raises(ValueError, match=r"of shape \(\.\.\., 3\)"):
        act(i, wrong)


@pytest.mark.parametrize("digits", [4, 6, 8, 12])
def test_rounded_matrices_give_the_nearest_rotation(digits):
    matrices = random_transforms(50, 1).as_matrix()
    rounded = matrices.round(digits)
    q = from_matrix(rounded, rtol=10.0**-digits)
    exact = Rotation.from_matrix(rounded[:, :3, :3]).as_quat(scalar_first=True)  # SciPy takes the nearest one too
    assert same_point(q.primal.coeffs[:, :4], exact).all()
    assert q.norm().coeffs == pytest.approx(np.eye(8)[[0] * 50], abs=1e-14)
    assert as_matrix(q)[:, :3, 3] == pytest.approx(rounded[:, :3, 3])


def test_single_precision_is_judged_by_its_own():
    matrices = random_transforms(50, 2).as_matrix().astype(np.float32)
    q = from_matrix(matrices)
    assert q.coeffs.dtype == float
    assert as_pose(q).shape == (50,)
    assert as_matrix(q) == pytest.approx(matrices, abs=1e-6)
    with pytest.raises(ValueError, match="give rtol="):
        from_matrix(matrices.astype(float))


def test_the_error_about_a_matrix_says_row_size_and_remedy():
    matrices = np.stack([np.eye(4)] * 5)
    matrices[3, 0, 0] += 1e-6
    with pytest.raises(
        ValueError, match=r"row 3: expected a rotation .* R Rᵀ is off 1 by 2e-06.* give rtol="
    ) as caught:
        from_matrix(matrices)
    advice = float(str(caught.value).rpartition("rtol=")[2])
    assert from_matrix(matrices, rtol=advice).shape == (5,)
    with pytest.raises(ValueError, match=r"rows 0, 1: .*reflection"):
        from_matrix(np.stack([np.diag([1, 1, -1, 1])] * 2))
    with pytest.raises(ValueError, match="row 1: expected the last row"):
        from_matrix(np.stack([np.eye(4), np.diag([1, 1, 1, 2])]))


def test_rows_that_are_no_displacements_may_become_nan():
    matrices = np.stack([np.eye(4), np.diag([1, 1, -1, 1]), np.diag([1, 1, 1, 2]), np.full((4, 4), np.nan), np.eye(4)])
    q = from_matrix(matrices, degenerate="nan")
    assert np.isnan(q.coeffs).all(axis=-1).tolist() == [False, True, True, True, False]
    assert q[4] == 1
    whole = from_matrix(np.stack([np.eye(4, dtype=int), np.diag([1, 1, -1, 1])]), degenerate="nan")
    assert np.isnan(whole.coeffs).all(axis=-1).tolist() == [False, True]
    assert np.isnan(from_matrix(matrices[[0, 3]]).coeffs).all(axis=-1).tolist() == [False, True]


@pytest.mark.parametrize("number", [math.nan, math.inf, 1j])
def test_single_numbers_are_real_and_finite(number):
    pose = DualQuaternion([number, 1, 0, 0, 0, 0, 0, 0])
    for use in (
        lambda: translation([number, 0, 0]),
        lambda: act(1 + i, [number, 0, 0]),
        lambda: act(pose, [1, 0, 0]),
        lambda: act(pose, z_axis),
        lambda: rotation(z_axis, number),
        lambda: as_matrix(pose),
        lambda: from_matrix(np.full((4, 4), number)),
    ):
        with pytest.raises(ValueError, match=r"expected (a )?(finite|real)"):
            use()


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_rows_of_a_batch_that_are_not_finite_become_nan(number):
    rows = np.array([[1.0, 0, 0], [number, 0, 0], [0, number, 2]])
    poses = DualQuaternion([[1, 0.5, 0, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, number, 0, 0], [number] * 8])
    results = (
        translation(rows).coeffs,
        act(1 + i, rows),
        act(poses, [1, 2, 3]),
        act(poses, z_axis).moment,
        rotation(z_axis, rows[:, :2].sum(axis=-1)).coeffs,
        as_matrix(poses)[:, :3].reshape(3, 12),
    )
    for result in results:
        assert np.isnan(result).all(axis=-1).tolist() == [False, True, True]


def test_rows_of_the_exceptional_space_may_become_nan():
    for scalar in (one, 1.0 * one):
        q = DualQuaternion.stack([one, eps * i, i]) * scalar
        for use in (
            lambda q, **kind: act(q, [1, 0, 0], **kind),
            lambda q, **kind: act(q, z_axis, **kind).direction,
            lambda q, **kind: as_matrix(q, **kind)[:, :3].reshape(3, 12),
            lambda q, **kind: axis_of(q * (i + j), **kind).coeffs,
        ):
            with pytest.raises(DegenerateError, match="row 1: ") as caught:
                use(q)
            assert caught.value.rows == (1,)
            assert np.isnan(use(q, degenerate="nan")).all(axis=-1).tolist() == [False, True, False]


def test_poses_of_every_form_move_points():
    q = translation([1, 2, 3]) * (1 + 2 * i + 2 * j)
    for pose in (as_matrix(q), as_matrix(q).tolist(), as_rigid_transform(q)):
        assert act(pose, [1, 1, 1]) == pytest.approx(as_float(act(q, [1, 1, 1])))
        assert as_float(as_matrix(pose)) == pytest.approx(as_float(as_matrix(q)))
    assert Line.from_dual_quaternion(axis_of(as_matrix(rotation(z_axis, 1.0)))).contains([0, 0, 5])


@pytest.mark.parametrize("wrong", [None, "pose", 3, z_axis, {}])
def test_other_things_are_no_displacements(wrong):
    for use in (lambda w: act(w, [1, 0, 0]), as_matrix, as_rigid_transform, axis_of):
        with pytest.raises(TypeError, match="expected a displacement"):
            use(wrong)
    with pytest.raises(TypeError, match="expected a RigidTransform"):
        from_rigid_transform(wrong)
    with pytest.raises(TypeError, match="expected a dual quaternion"):
        unit(wrong)


@pytest.mark.parametrize("wrong", [None, "line", [0, 0, 1], k])
def test_other_things_are_no_axes(wrong):
    for use in (half_turn, lambda w: rotation(w, 1.0)):
        with pytest.raises(TypeError, match="expected a Line"):
            use(wrong)


@pytest.mark.parametrize("wrong", [None, "abc", i, z_axis, [None] * 3])
def test_other_things_are_no_vectors_and_angles(wrong):
    for use in (translation, lambda w: rotation(z_axis, w), from_matrix):
        with pytest.raises(TypeError, match="expected numbers"):
            use(wrong)


@pytest.mark.parametrize("q", [eps, 0 * one, 0.0 * one])
def test_zero_has_no_unit(q):
    with pytest.raises(DegenerateError, match="primal part zero"):
        unit(q)


def test_angles_of_every_package():
    for angle in (sympy.Float(0.5), sympy.Rational(1, 2), np.float64(0.5), Fraction(1, 2)):
        assert rotation(z_axis, angle).coeffs == pytest.approx(rotation(z_axis, 0.5).coeffs)
