"""Section 3: null cone, 2R spaces, the lemmas and Theorem 1."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import sympy

from kinlib import (
    EXCEPTIONAL_SPACE,
    NULL_CONE,
    STUDY_QUADRIC,
    DegenerateError,
    DualQuaternion,
    Dyad,
    Subspace,
    eps,
    i,
    is_null_line,
    j,
    join,
    k,
    meet,
    null_form,
    one,
    recognise,
    same_point,
    study_form,
)
from problems import rational_half_turns

I = sympy.I
DYADS = [
    Dyad(h1, h2)
    for h1, h2 in (rational_half_turns(2, seed=seed) for seed in range(30))
    if study_form(h1, h2) != 0 and np.cross(h1.coeffs[1:4], h2.coeffs[1:4]).any()
][:5]
RIGHT = Dyad(i, j - eps * i)  # perpendicular skew axes


def symbols(name: str) -> DualQuaternion:
    return DualQuaternion(sympy.symbols(f"{name}0:8"))


def vanishes(q: DualQuaternion) -> bool:
    return all(sympy.expand(c) == 0 for c in q.coeffs)


def symbolic_half_turns():
    """h1 about the x-axis, h2 about any line at distance a: the general pair, up to a displacement."""
    a, c, s = sympy.symbols("a c s", real=True)
    return i, c * i + s * j + a * eps * (c * j - s * i), (a, c, s)


def on_circle(expression):
    """The value with c² + s² = 1."""
    c, s = sympy.symbols("c s", real=True)
    return sympy.rem(sympy.expand(expression), s**2 + c**2 - 1, s)


def test_the_null_cone_has_rank_four_and_the_exceptional_space_as_vertex():
    """N1."""
    assert NULL_CONE.rank() == 4
    singular = Subspace(NULL_CONE.singular_points())
    assert singular.contains(EXCEPTIONAL_SPACE)
    assert singular.dimension == EXCEPTIONAL_SPACE.dimension == 3
    assert STUDY_QUADRIC.contains(EXCEPTIONAL_SPACE)


def test_real_points_of_the_null_cone_are_exceptional():
    """N2: the form is positive on primal parts and does not see dual ones."""
    assert NULL_CONE.signature() == (4, 0)
    q = symbols("q")
    assert sympy.expand(null_form(q, q) - sum(x**2 for x in q.coeffs[:4])) == 0


@pytest.mark.parametrize("dyad", DYADS)
def test_the_image_of_a_dyad_spans_a_three_space_and_is_a_ruled_quadric(dyad):
    """D1."""
    space = dyad.space().as_subspace()
    assert space.dimension == 3
    assert one in space
    quadric = dyad.space().quadric()
    assert quadric.rank() == 4
    assert quadric.signature() == (2, 2)
    for ruling in (join(dyad(2, 0), dyad(2, 1)), join(dyad(0, 3), dyad(1, 3))):
        assert STUDY_QUADRIC.contains(ruling)
        assert ruling.contains(dyad(2, 5)) or ruling.contains(dyad(-1, 3))


def test_what_the_first_two_conditions_keep_out():
    """D2: each space with its own failure."""
    v = i + j + 2 * k
    cases = {
        "coplanar": [(one, i, j, k), (one, k, k + eps * i, eps * j)],
        "prismatic": [(one, k, eps * v, eps * k * v)],
        "complex": [(one, i + eps * i, j + eps * j, k + eps)],
        "rank 2": [(one, i, j + eps * j, k + eps * k)],
    }
    for message, spaces in cases.items():
        for points in spaces:
            with pytest.raises(DegenerateError, match=message):
                recognise(DualQuaternion.stack(points))


@pytest.mark.parametrize(
    ("basis", "rank"),
    [
        ((one, i, eps * j, eps * k), 0),
        ((one, k, eps * i, eps * j), 0),
        ((one, i, j, k), 0),
        ((one, i, j + eps * j, k + eps * k), 2),
    ],
    ids=["prismatic", "parallel", "intersecting", "complex"],
)
def test_null_quadrilaterals_come_with_all_that_is_kept_out_where_the_quadric_is_not_regular(basis, rank):
    """D2: so item 3 alone keeps out nothing."""
    corners = [basis[n] + s * basis[n + 1] for s in (I, -I) for n in (0, 2)]
    assert all(is_null_line(corners[n - 1], corners[n]) for n in range(4))
    assert sympy.Matrix([corner.coeffs for corner in corners]).rank() == 4
    assert sympy.Matrix(STUDY_QUADRIC.gram(basis)).rank() == rank


def test_a_prismatic_joint_with_a_regular_quadric_has_three_null_lines_only():
    """D2: Q is regular and ruled; the null cone is two planes that share a line of Q and cut one more each."""
    v = i + j + 2 * k
    space = join(one, k, eps * v, eps * k * v)
    assert STUDY_QUADRIC.restrict(space).rank() == 4
    assert STUDY_QUADRIC.restrict(space).signature() == (2, 2)
    assert NULL_CONE.restrict(space).rank() == 2
    assert is_null_line(eps * v, eps * k * v)
    for sign in (1, -1):
        points = (one + sign * I * k, eps * v, eps * k * v)
        gram = sympy.Matrix([[study_form(x, y) for x in points] for y in points])
        assert gram.applyfunc(sympy.expand).rank() == 2


def test_a_line_is_null_by_three_products():
    """L1: the norm of a point of the line is a quadratic polynomial with the three products as coefficients."""
    x, y = symbols("x"), symbols("y")
    t = sympy.Symbol("t")
    mixed = x * y.conjugate() + y * x.conjugate()
    assert vanishes((x + t * y).norm() - (x.norm() + t * mixed + t**2 * y.norm()))
    assert all(sympy.expand(c) == 0 for c in mixed.coeffs[[1, 2, 3, 5, 6, 7]])


def test_the_six_conditions_of_a_null_line_are_independent_at_those_of_a_dyad():
    """L1: their Jacobian has rank six there."""
    x, y = symbols("x"), symbols("y")
    mixed = x * y.conjugate() + y * x.conjugate()
    conditions = [c for q in (x.norm(), y.norm(), mixed) for c in q.coeffs[[0, 4]]]
    variables = [*x.coeffs, *y.coeffs]
    jacobian = sympy.Matrix(conditions).jacobian(variables)
    m = I - RIGHT.h1
    values = dict(zip(variables, [*m.coeffs, *(m * RIGHT.h2).coeffs], strict=True))
    assert jacobian.subs(values).rank() == 6


def test_the_product_of_two_turns_expanded():
    """L2a."""
    t1, t2 = sympy.symbols("t1 t2")
    h1, h2 = symbols("h"), symbols("k")
    assert vanishes((t1 - h1) * (t2 - h2) - (one * (t1 * t2) - h2 * t1 - h1 * t2 + h1 * h2))
    for dyad in DYADS:
        x0, x1, x2, x3 = dyad.coordinates(dyad(3, -2))
        assert x0 * x3 == x1 * x2
        assert dyad(float("inf"), float("inf")) == 1


def test_intersection_with_e_and_inclusion_in_s_by_the_axes():
    """L2b: with cosine c, sine s and distance a the null form has determinant s⁴ and b(h1, h2) = −as."""
    h1, h2, (a, c, s) = symbolic_half_turns()
    basis = (one, h1, h2, h1 * h2)
    gram = sympy.Matrix(4, 4, lambda m, n: on_circle(null_form(basis[m], basis[n])))
    assert on_circle(gram.det() - (1 - c**2) ** 2) == 0
    study = sympy.Matrix(4, 4, lambda m, n: on_circle(study_form(basis[m], basis[n])))
    assert all(sympy.expand(x).subs(a, 0) == 0 and sympy.expand(x).subs(s, 0) == 0 for x in study)
    assert study[1, 2] == -a * s


def test_intersection_with_e_on_exact_spaces():
    """L2b."""
    assert all(meet(dyad.space().as_subspace(), EXCEPTIONAL_SPACE).dimension == -1 for dyad in DYADS)
    assert not any(STUDY_QUADRIC.contains(dyad.space().as_subspace()) for dyad in DYADS)
    parallel, meeting = join(one, k, k + eps * i, eps * j), join(one, i, j, k)
    assert meet(parallel, EXCEPTIONAL_SPACE).dimension >= 0
    assert STUDY_QUADRIC.contains(parallel)
    assert STUDY_QUADRIC.contains(meeting)
    assert meet(meeting, EXCEPTIONAL_SPACE).dimension == -1


@pytest.mark.parametrize("dyad", DYADS[:3])
def test_four_null_lines_in_the_intersection_of_all_three(dyad):
    """L2c: x0x3 = x1x2 on the null cone factors into (t1² + 1)(t2² + 1)."""
    t1, t2 = sympy.symbols("t1 t2")
    pose = dyad(t1, t2)
    assert sympy.expand(null_form(pose, pose) - (t1**2 + 1) * (t2**2 + 1)) == 0
    for sign in (1, -1):
        assert is_null_line(dyad(sign * I, 0), dyad(sign * I, 1))
        assert is_null_line(dyad(0, sign * I), dyad(1, sign * I))


def test_the_null_cone_meets_the_space_in_a_regular_surface():
    """L2c: more than the four lines, for instance in 1 + √−1 h1h2, which is off the Study quadric."""
    space = RIGHT.space().as_subspace()
    assert NULL_CONE.restrict(space).rank() == 4
    x = one + I * (RIGHT.h1 * RIGHT.h2)
    assert sympy.expand(null_form(x, x)) == 0
    assert sympy.expand(study_form(x, x)) in (2 * I, -2 * I)
    for dyad in DYADS:
        x0, x1, x2, x3 = sympy.symbols("x0:4")
        point = one * x0 + dyad.h1 * x1 + dyad.h2 * x2 + dyad.h1 * dyad.h2 * x3
        c = null_form(dyad.h1, dyad.h2)
        expected = x0**2 + x1**2 + x2**2 + x3**2 - 2 * c * (x0 * x3 - x1 * x2)
        assert sympy.expand(null_form(point, point) - expected) == 0


def centres(dyad):
    """m1, n1, m2, n2 in the tangent hyperplane of the identity."""
    return I - dyad.h1, I - dyad.h2, -I - dyad.h1, -I - dyad.h2


@pytest.mark.parametrize("dyad", DYADS[:2])
def test_the_tangent_hyperplane_cuts_a_planar_quadrilateral(dyad):
    """L3a."""
    u1, v1, u2, v2 = dyad.space().null_quadrilateral()
    m1, n1, m2, n2 = centres(dyad)
    assert all(sympy.expand(study_form(one, x)) == 0 for x in (m1, n1, m2, n2))
    for x, (a, b) in zip((m1, n1, m2, n2), pairwise((u1, v1, u2, v2, u1)), strict=True):
        rows = sympy.Matrix([list(map(sympy.sympify, q.coeffs)) for q in (x, a, b)])
        assert rows.applyfunc(sympy.expand).rank() == 2
    rows = sympy.Matrix([list(map(sympy.sympify, q.coeffs)) for q in (m1, n1, m2, n2)])
    assert rows.rank() == 3
    assert same_point(m1 - m2, one)
    assert same_point(m1 + m2, dyad.h1)


@pytest.mark.parametrize("dyad", DYADS[:2])
def test_products_of_the_centres_span_null_lines(dyad):
    """L3b."""
    m1, n1, *_ = centres(dyad)
    for centre in (m1, n1):
        assert is_null_line(centre, m1 * n1)
        assert is_null_line(centre, n1 * m1)


@pytest.mark.parametrize("dyad", DYADS[:1])
def test_three_null_quadrilaterals(dyad):
    """L3c: u1, v1, u2, v2 go with m1n2, m1n1, m2n1, m2n2; the reversed one is different."""
    m1, n1, m2, n2 = centres(dyad)
    right = (m1 * n2, m1 * n1, m2 * n1, m2 * n2)
    reversed_products = (n2 * m1, n1 * m1, n1 * m2, n2 * m2)
    for quadrilateral in (right, reversed_products):
        assert all(is_null_line(x, y) for x, y in pairwise((*quadrilateral, quadrilateral[0])))
    found = dyad.space().null_quadrilateral()
    assert all(same_point(x, y) for x, y in zip(found, right, strict=True))
    assert not any(same_point(x, y) for x, y in zip(right, reversed_products, strict=True))


@pytest.mark.parametrize("dyad", DYADS[:2])
def test_the_reversed_vertex_is_off_the_projected_quadric(dyad):
    """L3d: its coordinates have x0x3 − x1x2 = 2(c ± 1), and the two families on {p p̄ = 0} are m1H and Hm1."""
    m1, n1, *_ = centres(dyad)
    c = null_form(dyad.h1, dyad.h2)
    x0, x1, x2, x3 = dyad.coordinates(n1 * m1)
    value = sympy.expand(sympy.sympify(x0 * x3 - x1 * x2))
    assert value != 0
    assert value in (2 * (c + 1), 2 * (c - 1), -2 * (c + 1), -2 * (c - 1))
    x0, x1, x2, x3 = dyad.coordinates(m1 * n1)
    assert sympy.expand(sympy.sympify(x0 * x3 - x1 * x2)) == 0


@pytest.mark.parametrize("dyad", DYADS)
def test_one_order_of_the_product_is_in_the_space(dyad):
    """L3e."""
    space = dyad.space()
    assert dyad.h1 * dyad.h2 in space
    assert dyad.h2 * dyad.h1 not in space
    found = recognise(Dyad(dyad.h2, dyad.h1).space())
    assert same_point(found.h1, dyad.h2)


@pytest.mark.parametrize("dyad", DYADS)
def test_theorem_1_both_directions(dyad):
    """T1: a 2R space is recognised; bent a little it is refused."""
    h1, h2 = dyad.h1, dyad.h2
    points = [one + h1, h1 - 2 * h2, h2 + h1 * h2, h1 * h2 + one * 3]
    found = recognise(DualQuaternion.stack(points))
    assert same_point(found.h1, h1)
    assert same_point(found.h2, h2)
    refused = 0
    for bend in (eps, eps * i, eps * j, eps * k):
        try:
            bent = recognise(DualQuaternion.stack([one, h1, h2, h1 * h2 + bend / 7]))
        except DegenerateError:
            refused += 1
        else:
            assert bent.h1 * bent.h2 in bent.space()
    assert refused >= 3


@pytest.mark.parametrize("coplanar", [True, False])
def test_projections_compose_to_the_identity_exactly_if_the_centres_are_coplanar(coplanar):
    """L4: four projections with centres m1, n1, m2, n2 on the sides of a spatial quadrilateral."""
    u1, v1, u2, v2 = one + eps * i, i + eps * (j + k), j - eps * i, k + 2 * eps
    centres = [u1 + v1, v1 + u2, u2 + v2, v2 + (u1 if coplanar else 2 * u1)]
    assert join(*centres).dimension == (2 if coplanar else 3)
    spaces = [join(EXCEPTIONAL_SPACE, x) for x in (v1, u2, v2, u1)]
    start = u1 + eps * (i + 3 * j - k)
    point = start
    for centre, space in zip(centres, spaces, strict=True):
        image = meet(join(point, centre), space)
        assert image.dimension == 0
        point = DualQuaternion(image.basis[0])
    assert same_point(point, start) is coplanar
