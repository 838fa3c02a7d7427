"""Laws of every public function and class, tried on all shapes and all kinds of numbers; the rest is next door."""

import copy
import importlib
import math
import pickle
from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest

import kinlib
from kinlib import (
    NULL_CONE,
    STUDY_QUADRIC,
    Chain,
    DualQuaternion,
    Line,
    Quadric,
    act,
    as_float,
    as_matrix,
    as_pose,
    as_rigid_transform,
    as_scalars,
    axis_of,
    bennett_flip,
    bennett_linkage,
    binary_roots,
    common_perpendicular,
    conic_through,
    divide,
    eps,
    exchange,
    factorizations,
    factorize,
    from_matrix,
    from_rigid_transform,
    half_turn,
    i,
    is_exact,
    is_null_line,
    is_zero,
    j,
    join,
    k,
    linear_factor,
    meet,
    null_form,
    null_space,
    one,
    quadratic_factors,
    quadratic_of,
    rotation,
    same_point,
    size,
    square_root,
    study_form,
    study_projection,
    translation,
    unit,
)  # fmt: skip
from kinlib.testing import random_poses
from laws import (
    ALL,
    COVERED,
    EXACT,
    REAL,
    SHAPES,
    Rowwise,
    arrays_of,
    assert_same,
    assert_same_numbers,
    assert_same_poses,
    assert_zero,
    in_floats,
    law,
    row,
    row_of,
    with_nan,
)  # fmt: skip

# --- the algebra ------------------------------------------------------------------------------------------------


@law("DualQuaternion", kinds=ALL, q="dual_quaternion", r="dual_quaternion", s="dual_quaternion")
def test_the_product_is_associative_and_distributes(q, r, s):
    assert_same((q * r) * s, q * (r * s))
    assert_same(q * (r + s), q * r + q * s)
    assert_same((q - r) * s, q * s - r * s)


@law("one", "i", "j", "k", "eps", kinds=ALL, q="dual_quaternion", x="scalar")
def test_the_units(q, x):
    assert i * i == j * j == k * k == i * j * k == -1
    assert eps * eps == 0
    assert_same(one * q, q)
    assert_same(eps * q, q * eps)
    assert_same(x * q, q * x)


@law("DualQuaternion", kinds=ALL, q="dual_quaternion", r="dual_quaternion")
def test_conjugations(q, r):
    assert_same((q * r).conjugate(), r.conjugate() * q.conjugate())
    assert_same((q * r).eps_conjugate(), q.eps_conjugate() * r.eps_conjugate())
    assert_same((q * r).norm(), q.norm() * r.norm())
    assert_same(q.primal + eps * q.dual, q)


@law("DualQuaternion", kinds=(*REAL, "complex"), q="dual_quaternion", r="dual_quaternion")
def test_division(q, r):
    assert_same(q * q.inverse(), one)
    assert_same((q * r) / r, q)
    assert_same(q**-2 * q**3, q)


@law("DualQuaternion", kinds=(*REAL, "complex"), q="dual_quaternion")
def test_what_is_copied_is_equal(q):
    for same in (copy.copy(q), copy.deepcopy(q), pickle.loads(pickle.dumps(q)), DualQuaternion(q.coeffs)):
        assert np.all(same == q)
        assert same.shape == q.shape
        assert not same.coeffs.flags.writeable


@law("DualQuaternion", q="dual_quaternion")
def test_length_index_and_iteration_mean_the_batch(q):
    assert np.shape(q.coeffs) == (*q.shape, 8)
    if not q.shape:
        with pytest.raises(TypeError):
            len(q)
        return
    assert len(q) == q.shape[0] == len(list(q))
    assert_same(DualQuaternion.stack(list(q)), q)


@law("study_form", "null_form", kinds=ALL, x="dual_quaternion", y="dual_quaternion", z="dual_quaternion", s="scalar")
def test_the_two_forms_polarise_the_norm(x, y, z, s):
    both = x * y.conjugate() + y * x.conjugate()
    assert_same(both, _dual(2 * null_form(x, y), 2 * study_form(x, y)))
    for form in (study_form, null_form):
        assert_same(form(x, y), form(y, x))
        assert_same(form(x * s + z, y), s * form(x, y) + form(z, y))


def _dual(a, b) -> DualQuaternion:
    """The dual number a + εb."""
    return one * a + eps * b


# --- displacements ----------------------------------------------------------------------------------------------


@law("act", kinds=REAL, q="pose", r="pose", x="point", s="scalar")
def test_displacements_act_on_points(q, r, x, s):
    assert_same(act(q * r, x), act(q, act(r, x)))
    assert_same(act(q.inverse(), act(q, x)), x)
    assert_same(act(q * s, x), act(q, x))


@law("act", "Line", q="pose", r="pose", line="line", x="point")
def test_displacements_act_on_lines(q, r, line, x):
    assert_same(act(q * r, line), act(q, act(r, line)))
    foot = line.foot(x)
    assert np.all(act(q, line).contains(act(q, foot)))


@law("act", "DualQuaternion", kinds=REAL, q="pose", line="line")
def test_moving_a_line_is_conjugating_its_half_turn(q, line):
    moved = q * half_turn(line) * q.conjugate() / null_form(q, q)
    assert_same(half_turn(act(q, line)), moved)


@law("as_matrix", "from_matrix", "as_pose", kinds=REAL, q="pose", r="pose")
def test_matrices_are_another_name_for_poses(q, r):
    assert_same(as_matrix(q * r), as_matrix(q) @ as_matrix(r))
    if all(n.dtype != object for n in (q.coeffs,)) or not hasattr(q.coeffs.flat[0], "field"):
        assert_same_poses(from_matrix(as_matrix(q)), q)
        assert_same_poses(as_pose(as_matrix(q)), as_pose(q))


@law("as_rigid_transform", "from_rigid_transform", kinds=("float",), q="pose", x="point")
def test_scipy_says_the_same(q, x):
    transform = as_rigid_transform(q)
    assert_same_poses(from_rigid_transform(transform), q)
    assert_same_poses(as_pose(transform), q)
    if q.shape in ((), (1,)):
        assert_same(transform.apply(x), act(q, x))


@law("translation", kinds=REAL, v="vector", w="vector", x="point")
def test_translations_add(v, w, x):
    assert_same(translation(v) * translation(w), translation(v + w))
    assert_same(act(translation(v), x), x + v)


@law("rotation", "half_turn", "unit", kinds=("float",), line="line", a="angle", b="angle", x="point")
def test_rotations_about_a_line(line, a, b, x):
    turn = rotation(line, a)
    assert_same(turn * rotation(line, b), rotation(line, a + b))
    assert_same(act(turn, line.foot(x)), line.foot(x))
    assert_same(rotation(line, np.pi + 0 * a), unit(half_turn(line)))
    assert_same(null_form(turn, turn), 1 + 0 * a)


@law("half_turn", "axis_of", "Line", kinds=REAL, line="line", x="point")
def test_a_half_turn_undoes_itself(line, x):
    h = half_turn(line)
    assert_same(act(h, act(h, x)), x)
    middle = (x + act(h, x)) / 2
    assert_same(middle, line.foot(x))
    assert_same(Line.from_dual_quaternion(h), line)


@law("axis_of", "unit", kinds=("float", "fraction"), h="half_turn", s="scalar", r="scalar")
def test_the_axis_of_a_rotation(h, s, r):
    axis = axis_of(h * s + r)
    assert_same_poses(axis, h)
    assert_same_poses(unit(h * s), h)


@law("unit", kinds=("float",), q="pose")
def test_unit_poses(q):
    assert_same(null_form(unit(q), unit(q)), 1 + 0 * q.scalar_part)
    assert_same_poses(unit(q), q)


@law("study_projection", kinds=REAL, q="dual_quaternion", p="pose", x="point")
def test_the_study_projection(q, p, x):
    pose = study_projection(q)
    assert_zero(study_form(pose, pose), size(pose.coeffs) ** 2)
    assert_same_poses(pose.primal, q.primal)
    assert_same_poses(study_projection(p), p)


@law("as_pose", lengths=(), q="pose", r="pose")
def test_what_is_computed_from_poses_is_a_pose(q, r):
    for computed in (q * q.inverse(), q * r.inverse(), q * r * q * r, translation([1000, 0, 0]) * q):
        assert_same_poses(as_pose(computed), computed, length=1000.0)


@pytest.mark.parametrize("seed", range(50))
def test_rounding_does_not_unmake_poses(seed):
    poses = random_poses(3, seed=seed)
    seen = [p * poses[0].inverse() for p in poses]
    assert bennett_linkage(*seen).closure_residual() < 1e-9


# --- lines ------------------------------------------------------------------------------------------------------


@law("Line", kinds=REAL, a="point", b="point", v="vector")
def test_lines_pass_through_their_points(a, b, v):
    line = Line.through(a, b)
    assert np.all(line.contains(a))
    assert np.all(line.contains(b))
    assert np.all(Line.at(a, v).contains(a + v * 2))


@law("Line", kinds=("float", "fraction"), line="line", x="point")
def test_the_foot_is_the_nearest_point(line, x):
    foot = line.foot(x)
    assert np.all(line.contains(foot))
    assert_zero(((x - foot) * line.direction).sum(-1), size(x) * size(line.direction))


@law("Line", "common_perpendicular", kinds=("float", "fraction"), first="line", second="line", q="pose")
def test_the_common_perpendicular(first, second, q):
    a, b = common_perpendicular(first, second)
    assert np.all(first.contains(a))
    assert np.all(second.contains(b))
    for line in (first, second):
        assert_zero(((a - b) * line.direction).sum(-1), size(a) * size(line.direction))
    moved = common_perpendicular(act(q, first), act(q, second))
    assert_same(list(moved), [act(q, a), act(q, b)], rtol=1e-7)


@law("Line", kinds=("float",), first="line", second="line", q="pose")
def test_distance_and_angle_are_seen_alike_from_everywhere(first, second, q):
    assert_same(first.distance(second), second.distance(first))
    assert_same(act(q, first).distance(act(q, second)), first.distance(second), rtol=1e-7)
    assert_same(act(q, first).angle(act(q, second)), first.angle(second), rtol=1e-7)
    h, g = half_turn(first), half_turn(second)
    sine = np.sin(first.angle(second)) * np.sqrt(null_form(h, h) * null_form(g, g))
    assert_same(np.abs(study_form(h, g)), first.distance(second) * sine)


@law("Line", kinds=("float", "fraction"), line="line", v="vector")
def test_parallel_lines_have_a_distance(line, v):
    other = act(translation(v), line)
    across = v - (v * line.direction).sum(-1, keepdims=True) * line.direction / (line.direction**2).sum(
        -1, keepdims=True
    )
    assert_same(
        np.asarray(line.distance(other), dtype=float) ** 2, np.asarray((across**2).sum(-1), dtype=float), rtol=1e-7
    )


# --- projective geometry ----------------------------------------------------------------------------------------


@law("same_point", kinds=(*REAL, "complex"), x="dual_quaternion", y="dual_quaternion", s="scalar")
def test_points_are_coefficients_up_to_a_factor(x, y, s):
    assert np.all(same_point(x * s, x))
    assert not np.any(same_point(x, y))
    assert np.shape(same_point(x, y)) == x.shape


@law("join", "meet", "null_space", "Subspace", kinds=(*REAL, "complex"), shapes=((5,),), points="dual_quaternion")
def test_dimensions_of_join_and_meet(points):
    first, second = join(points[0], points[1], points[2]), join(points[2], points[3], points[4])
    both, common = join(first, second), meet(first, second)
    assert first.dimension + second.dimension == both.dimension + common.dimension == 4
    assert points[2] in common
    assert points[4] not in first
    assert points[0] + points[1] * 3 in first
    assert_zero(first.equations() @ first.basis.T)
    assert_zero(null_space(first.basis) @ first.basis.T)


@law("Quadric", "STUDY_QUADRIC", "NULL_CONE", "EXCEPTIONAL_SPACE", kinds=REAL, x="dual_quaternion", q="pose")
def test_the_quadrics_are_their_forms(x, q):
    assert_same(STUDY_QUADRIC.form(x, q), study_form(x, q))
    assert_same(NULL_CONE.form(x, q), null_form(x, q))
    assert np.all(STUDY_QUADRIC.contains(q))
    assert_same((STUDY_QUADRIC.tangent_hyperplane(x) * q.coeffs).sum(-1), study_form(x, q))
    assert STUDY_QUADRIC.contains(kinlib.EXCEPTIONAL_SPACE)
    assert STUDY_QUADRIC.signature() == (4, 4)


@law("Quadric", "Subspace", kinds=REAL, shapes=((3,),), points="dual_quaternion", s="scalar")
def test_a_quadric_restricted_to_a_subspace(points, s):
    plane = join(*points)
    section = STUDY_QUADRIC.restrict(plane)
    x = DualQuaternion((plane.basis * s[:, None]).sum(0))
    assert_same(section.form(s, s), study_form(x, x))
    assert isinstance(section, Quadric)
    assert section.rank() == 3


@law("binary_roots", kinds=("float", "fraction"), shapes=((),), a="scalar", b="scalar", r="scalar", s="scalar")
def test_binary_roots_are_roots(a, b, r, s):
    form = a * r, -(a * s + b * r) / 2, b * s  # (a x − b y)(r x − s y)
    for x, y in binary_roots(*form):
        assert_zero(form[0] * x * x + 2 * form[1] * x * y + form[2] * y * y, 10 * size(form) * size([x, y]) ** 2)


@law("is_null_line", "Dyad", "TwoRSpace", "NullQuadrilateral", kinds=("float",), shapes=((),), dyad="dyad", q="pose")
def test_null_quadrilaterals_move_with_the_frame(dyad, q):
    vertices = dyad.space().null_quadrilateral()
    for x, y in zip(vertices, (*vertices[1:], vertices[0]), strict=True):
        assert is_null_line(x, y)
        assert is_null_line(q * x, q * y)
    assert not is_null_line(vertices[0], vertices[2])


# --- numbers ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("x", [0, 1, Fraction(9, 4), 2, 8, Fraction(2, 3), 10**30 + 1, 2.0, 0.0])
def test_a_square_root_squares_to_its_square(x):
    root = square_root(x)
    assert_same(root * root, x)
    assert float(root) >= 0
    assert float(root) == pytest.approx(math.sqrt(x))


COVERED.update(("square_root", "NumberField", "NumberFieldElement"))


@law("NumberField", "NumberFieldElement", kinds=("field",), shapes=((),), x="scalar", y="scalar", z="scalar")
def test_number_fields_are_fields(x, y, z):
    assert x * (y + z) == x * y + x * z
    assert x / y * y == x
    assert (x < y) == (float(x) < float(y))
    assert float(x * y) == pytest.approx(float(x) * float(y))
    assert hash(x * y) == hash(y * x)


# --- motion polynomials -----------------------------------------------------------------------------------------


@law("MotionPolynomial", kinds=REAL, C="polynomial", D="polynomial", t="scalar")
def test_evaluation_respects_sums_and_products(C, D, t):
    t = t if C.shape == () else np.asarray(t)
    assert_same((C * D)(t), C(t) * D(t))
    assert_same((C + D)(t), C(t) + D(t))
    assert_same(C.conjugate()(t), C(t).conjugate())
    assert_same(C(math.inf), C.leading)


@law("MotionPolynomial", kinds=REAL, C="polynomial", D="polynomial")
def test_division_with_remainder(C, D):
    quotient, remainder = divmod(C * D + D.leading, D)
    assert_same((quotient * D + remainder).coeffs[..., -5:, :], (C * D + D.leading).coeffs)
    assert remainder.degree < D.degree


@law("MotionPolynomial", kinds=REAL, C="motion")
def test_products_of_linear_factors_are_motions(C):
    assert np.all(C.is_motion())
    assert_zero(C.study_polynomial(), size(C.coeffs) ** 2)


@law("MotionPolynomial", "RationalCurve", kinds=("float", "fraction"), shapes=((),), C="motion", x="point", t="scalar")
def test_trajectories_are_where_points_go(C, x, t):
    assert_same(C.trajectory(x)(t), act(C(t), x))


@law("linear_factor", "MotionPolynomial", kinds=REAL, h="half_turn", t="scalar")
def test_a_linear_factor_turns_about_its_axis(h, t):
    t = t if not h.shape else np.asarray(t)
    assert_same(linear_factor(h)(t), t - h)
    assert_same(Line.from_dual_quaternion(h).foot(), act(linear_factor(h)(t), Line.from_dual_quaternion(h).foot()))


@law("bennett_flip", kinds=REAL, h="rotation", g="rotation")
def test_the_bennett_flip_exchanges_quadratics(h, g):
    a, b = bennett_flip(h, g)
    assert_same(linear_factor(a) * linear_factor(b), linear_factor(h) * linear_factor(g), rtol=1e-7)
    assert_same(a.scalar_part, g.scalar_part, rtol=1e-7)
    assert_same(null_form(b, b), null_form(h, h), rtol=1e-7)
    assert_same(list(bennett_flip(a, b)), [h, g], rtol=1e-6)


@law("exchange", "quadratic_of", kinds=("float", "fraction"), h="rotation", g="rotation", f="rotation")
def test_an_exchange_of_neighbours_exchanges_their_quadratics(h, g, f):
    a, b, c = exchange((f, h, g), 1)
    assert_same(a, f)
    assert_same(linear_factor(b) * linear_factor(c), linear_factor(h) * linear_factor(g), rtol=1e-7)
    assert_same([quadratic_of(b), quadratic_of(c)], [quadratic_of(g), quadratic_of(h)], rtol=1e-6)


@law("factorizations", "factorize", "quadratic_factors", kinds=("float", "fraction"), h="rotation", g="rotation")
def test_factorizations_multiply_to_the_polynomial(h, g):
    C = linear_factor(h) * linear_factor(g)
    found = factorizations(C)
    assert len(found) == 2
    for order, factors in zip(permutations(range(2)), found, strict=True):
        a, b = factors
        assert_same(linear_factor(a) * linear_factor(b), C, rtol=1e-7)
        assert_same(list(factorize(C, order)), list(factors))
    quadratics = quadratic_factors(C.norm_polynomial())
    assert quadratics.shape == (*C.shape, 2, 3)


@law("quadratic_factors", kinds=("float", "fraction"), x="scalar", y="scalar", u="scalar", v="scalar")
def test_quadratic_factors_multiply_to_the_polynomial(x, y, u, v):
    first, second = ((-2 * a, a * a + b * b) for a, b in ((x, y), (u, v)))
    quartic = np.stack(
        [0 * x + 1, first[0] + second[0], first[1] + second[1] + first[0] * second[0],
         first[0] * second[1] + second[0] * first[1], first[1] * second[1]], axis=-1,
    )  # fmt: skip
    found = quadratic_factors(quartic)
    assert found.shape == (*np.shape(x), 2, 3)
    b, c = found[..., 1], found[..., 2]
    product = np.stack(
        [b.sum(-1), c.sum(-1) + b.prod(-1), b[..., 0] * c[..., 1] + b[..., 1] * c[..., 0], c.prod(-1)], axis=-1
    )
    assert_same_numbers(product, quartic[..., 1:], rtol=1e-7)


# --- functions that work row by row -----------------------------------------------------------------------------

ROWWISE = [
    Rowwise(("DualQuaternion",), lambda q, r: q * r, ("dual_quaternion", "dual_quaternion")),
    Rowwise(("DualQuaternion",), lambda q: q.inverse(), ("dual_quaternion",)),
    Rowwise(("DualQuaternion",), lambda q: q.norm(), ("dual_quaternion",)),
    Rowwise(("study_form",), study_form, ("dual_quaternion", "dual_quaternion")),
    Rowwise(("null_form",), null_form, ("dual_quaternion", "dual_quaternion")),
    Rowwise(("act",), lambda q, x: DualQuaternion(_padded(act(q, x))), ("pose", "point")),
    Rowwise(("act",), act, ("pose", "line")),
    Rowwise(("as_matrix",), lambda q: _flat(as_matrix(q)), ("pose",)),
    Rowwise(("translation",), translation, ("vector",)),
    Rowwise(("rotation",), rotation, ("line", "angle"), exact=False),
    Rowwise(("half_turn",), half_turn, ("line",)),
    Rowwise(("unit",), unit, ("pose",), exact=False),
    Rowwise(("axis_of",), axis_of, ("rotation",), exact=False),
    Rowwise(("study_projection",), study_projection, ("dual_quaternion",)),
    Rowwise(("Line",), lambda line, x: DualQuaternion(_padded(line.foot(x))), ("line", "point")),
    Rowwise(("Line",), lambda a, b: a.angle(b), ("line", "line")),
    Rowwise(("Line",), lambda a, b: a.distance(b), ("line", "line"), exact=False),  # roots leave a field
    Rowwise(
        ("common_perpendicular",),
        lambda a, b: [DualQuaternion(_padded(x)) for x in common_perpendicular(a, b)],
        ("line", "line"),
    ),
    Rowwise(("same_point",), same_point, ("dual_quaternion", "dual_quaternion")),
    Rowwise(("MotionPolynomial",), lambda C, D: C * D, ("polynomial", "polynomial")),
    Rowwise(("MotionPolynomial",), lambda C, t: C(t), ("polynomial", "scalar")),
    Rowwise(("linear_factor",), linear_factor, ("rotation",)),
    Rowwise(("bennett_flip",), bennett_flip, ("rotation", "rotation")),
    Rowwise(("Dyad",), lambda dyad, s, t: dyad(s, t), ("dyad", "scalar", "scalar")),
    Rowwise(("Dyad",), lambda dyad, s, t: list(dyad.parameters(dyad(s, t))), ("dyad", "scalar", "scalar")),
    Rowwise(("conic_through",), conic_through, ("pose", "pose", "pose")),
]


def name_of(call: Rowwise) -> str:
    return "-".join((*call.names, *call.takes))


rowwise = pytest.mark.parametrize("call", ROWWISE, ids=name_of)


def _flat(matrix) -> DualQuaternion:
    """The twelve numbers of a matrix in two dual quaternions, so that the batch is what is left."""
    rows = matrix[..., :3, :]
    return [DualQuaternion(np.concatenate([rows[..., n, :], rows[..., n, :]], axis=-1)) for n in range(3)]


def _padded(vectors) -> np.ndarray:
    assert vectors.dtype.kind != "O" or not any(isinstance(x, float) for x in vectors.flat)
    return np.concatenate([vectors, np.zeros((*np.shape(vectors)[:-1], 5), dtype=int)], axis=-1)


@rowwise
@pytest.mark.parametrize("kind", ["float", "fraction"])
@pytest.mark.parametrize("shape", SHAPES[1:])
def test_a_batch_is_its_rows(call, kind, shape):
    arguments = call.draw(kind, shape)
    together = call.function(*arguments)
    for index in np.ndindex(*shape):
        alone = call.function(*[row(x, index) for x in arguments])
        for x, y in zip([x for x, _ in arrays_of(alone)], row_of(together, shape, index), strict=True):
            assert_same_numbers(x, y)


@pytest.mark.parametrize("call", [call for call in ROWWISE if len(call.takes) > 1], ids=name_of)
def test_arguments_broadcast(call):
    first = call.draw("float", (3, 1, 2))[0]
    small = call.draw("float", (2,), seed=1)[1:]
    wide = call.function(first, *small)
    for index in np.ndindex(3, 1, 2):
        alone = call.function(row(first, index), *[row(x, index[-1:]) for x in small])
        for x, y in zip([x for x, _ in arrays_of(alone)], row_of(wide, (3, 1, 2), index), strict=True):
            assert_same_numbers(x, y)


@pytest.mark.parametrize("call", [call for call in ROWWISE if call.exact], ids=name_of)
@pytest.mark.parametrize("kind", EXACT)
def test_exact_numbers_say_the_same_as_floats(call, kind):
    arguments = call.draw(kind)
    exact, floats = call.function(*arguments), call.function(*[in_floats(x) for x in arguments])
    for (x, _), (y, _) in zip(arrays_of(exact), arrays_of(floats), strict=True):
        assert_same_numbers(np.asarray(x).astype(float), np.asarray(y).astype(float), rtol=1e-7)


@pytest.mark.parametrize("call", [call for call in ROWWISE if len(call.takes) > 1], ids=name_of)
def test_exact_numbers_beside_floats_are_floats(call):
    arguments = call.draw("fraction", (2,))
    expected = call.function(*[in_floats(x) for x in arguments])
    for n in range(len(arguments)):
        found = call.function(*[in_floats(x) if m == n else x for m, x in enumerate(arguments)])
        for (x, _), (y, _) in zip(arrays_of(found), arrays_of(expected), strict=True):
            assert x.dtype == y.dtype, f"floats in argument {n}"
            assert_same_numbers(x, y)


@rowwise
def test_a_nan_row_stays_a_row(call):
    shape, spoiled = (3,), (1,)
    first, *others = call.draw("float", shape)
    expected = call.function(first, *others)
    with np.errstate(all="ignore"):
        try:
            found = call.function(with_nan(first, spoiled), *others)
        except ValueError as error:
            names_its_row = "row 1" in str(error) or "rows 1" in str(error)
            assert names_its_row, error  # noqa: PT017 - either answer is right
            return
    for index in ((0,), (2,)):
        for x, y in zip(row_of(found, shape, index), row_of(expected, shape, index), strict=True):
            assert_same_numbers(x, y)
    middle = np.concatenate([np.ravel(x) for x in row_of(found, shape, spoiled)])
    assert middle.dtype.kind == "b" or np.isnan(middle).any()


# --- scalars and chains -----------------------------------------------------------------------------------------


@law("divide", "is_zero", kinds=(*REAL, "complex"), x="scalar", y="scalar")
def test_quotients_undo_products(x, y):
    assert_same(divide(x * y, y), x)
    assert np.all(is_zero(divide(x, y) * y - x, abs(np.asarray(x).astype(complex))))
    assert not np.any(is_zero(x))


@law("as_scalars", "as_float", "is_exact", "size", kinds=REAL, x="vector")
def test_numbers_stay_what_they_are(x):
    stored = as_scalars(x)
    assert_same(stored, x)
    assert is_exact(stored) == is_exact(x)
    assert not is_exact(as_float(x))
    assert_same_numbers(size(x, -1), np.abs(as_float(x)).max(-1))


@law("Chain", kinds=("float", "fraction"), a="half_turn", b="half_turn", c="half_turn", d="half_turn", q="pose")
def test_a_chain_is_the_same_from_everywhere(a, b, c, d, q):
    axes = DualQuaternion.stack([a, b, c, d], axis=-1)
    turned = q[..., None] if q.shape else q
    chain, moved = Chain(axes), Chain(unit(turned * axes * turned.conjugate()))
    assert (chain.joint_count, chain.shape) == (4, a.shape)
    assert np.all(np.asarray(chain.mobility()) == 0)
    for link, other in zip(chain.denavit_hartenberg(), moved.denavit_hartenberg(), strict=True):
        assert_same(list(link), list(other), rtol=1e-6)
    bars, place = moved.bars(), q.astype(float)[..., None, None] if q.shape else q.astype(float)
    assert_same(act(place, chain.bars()), bars, rtol=1e-6)


# --- none is left out -------------------------------------------------------------------------------------------


def test_every_public_name_has_a_law():
    for laws in ("test_laws_of_synthesis", "test_search", "test_stops", "test_task"):
        importlib.import_module(laws)
    COVERED.update(name for call in ROWWISE for name in call.names)
    kinds_of_arguments = {name for name in kinlib.__all__ if not callable(getattr(kinlib, name)) or _is_alias(name)}
    assert sorted(set(kinlib.__all__) - COVERED - kinds_of_arguments) == []


def _is_alias(name: str) -> bool:
    return hasattr(kinlib, "typing") and name in kinlib.typing.__all__
