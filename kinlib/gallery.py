"""Named exact poses and linkages, as literals; each has a test of its own hypotheses."""

from fractions import Fraction

from kinlib.dual_quaternion import DualQuaternion

__all__ = ["FIELD_OF_DEGREE_SIX", "FOUR_POSES", "LINEAR_TERMS_EQUAL", "THREE_POSES"]

THREE_POSES = (
    DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([-4, -3, 0, 0, -3, 4, 0, 0]),
    DualQuaternion([-14, -3, 3, -6, -3, 4, -4, 3]),
)
"""Three poses with whole coefficients on the dyad with axes k and (3j + 4k − 4εj + 3εk)/5: rational throughout."""

LINEAR_TERMS_EQUAL = (
    DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([Fraction(3, 5), 0, 0, Fraction(4, 5), 4, 1, 2, -3]),
    DualQuaternion([Fraction(8, 5), Fraction(6, 5), Fraction(3, 5), Fraction(4, 5), 4, Fraction(-7, 3), 2, -6]),
)
"""Three poses whose conic has the norm t⁴ + 3t² + 1: its two quadratic factors have equal linear terms."""

FOUR_POSES = (
    DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([1, 1, 2, -2, -1, 1, 2, 2]),
    DualQuaternion([0, -1, 0, 0, 2, 0, 0, -1]),
    DualQuaternion([1, -2, 1, 2, -1, 2, 1, 2]),
)
"""Four poses with whole coefficients for which both families of cubics are real: t3 = 4/3 and t3 = −1."""

FIELD_OF_DEGREE_SIX = (
    DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([1, 0, -1, -1, -2, 2, -2, 0]),
    DualQuaternion([0, 0, 1, -1, 2, -2, -1, -1]),
)
"""Three poses with whole coefficients whose dyads need ℚ(a) with a⁶ + 8a⁴ + 8a² = 16."""
