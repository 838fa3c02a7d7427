"""What hypothesis draws: small whole numbers, so that every law is checked exactly."""

from fractions import Fraction

from hypothesis import assume, settings
from hypothesis import strategies as st

from kinlib import DualQuaternion, Line, MotionPolynomial, square_root, translation

settings.register_profile("kinlib", deadline=None, derandomize=True, max_examples=25)
settings.load_profile("kinlib")

whole = st.integers(-9, 9)
large = st.integers(-(2**70), 2**70)
fractions = st.fractions(-9, 9, max_denominator=12)
gaussian = st.builds(complex, whole, whole)

in_field = st.builds(lambda r, s: r + s * square_root(2), fractions, whole)

vectors = st.lists(whole, min_size=3, max_size=3)
fraction_vectors = st.lists(fractions, min_size=3, max_size=3)


def dual_quaternions(scalars=whole):
    """Any eight coefficients."""
    return st.lists(scalars, min_size=8, max_size=8).map(DualQuaternion)


def several(count: int, kinds=(whole, fractions, gaussian, in_field)):
    """Dual quaternions with scalars of one kind."""
    return st.sampled_from(kinds).flatmap(lambda scalars: st.tuples(*[dual_quaternions(scalars)] * count))


@st.composite
def lines(draw):
    """Lines through two different points with whole coordinates."""
    a, b = draw(vectors), draw(vectors)
    assume(a != b)
    return Line.through(a, b)


@st.composite
def poses(draw):
    """Rational points of the Study quadric that are displacements."""
    primal = draw(st.lists(whole, min_size=4, max_size=4).filter(any))
    return translation(draw(fraction_vectors)) * DualQuaternion(primal + [0] * 4)


@st.composite
def rotations(draw):
    """Rational rotations about lines anywhere, as s − h."""
    return draw(fractions) - draw(lines()).as_dual_quaternion()


def motion_polynomials(degree: int, scalars=whole):
    """Polynomials with any coefficients, not only motions."""
    return st.lists(dual_quaternions(scalars), min_size=degree + 1, max_size=degree + 1).map(
        MotionPolynomial.from_coefficients
    )


def as_fractions(q: DualQuaternion) -> DualQuaternion:
    """The same value in Python's own arithmetic, which cannot overflow."""
    return DualQuaternion([Fraction(int(c)) for c in q.coeffs])
