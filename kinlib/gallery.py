"""Named exact poses and linkages, as literals; each has a test of its own hypotheses."""

from fractions import Fraction

from kinlib.dual_quaternion import DualQuaternion

__all__ = [
    "BENNETT_OF_HEGEDUS",
    "FIELD_OF_DEGREE_SIX",
    "FOUR_POSES",
    "LINEAR_TERMS_EQUAL",
    "LINE_SYMMETRIC",
    "PARALLELOGRAM",
    "PLACES_OF_4R",
    "PLACES_OF_6R",
    "PLANE_FOLD",
    "POSES_OF_BRUNNTHALER",
    "THREE_POSES",
    "THREE_ROTATIONS",
]

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

POSES_OF_BRUNNTHALER = (
    DualQuaternion([0, 17, -33, -89, 0, 6, -5, 3]),
    DualQuaternion([0, 84, -21, -287, 0, 30, -3, 9]),
    DualQuaternion([0, 10, 37, -84, 0, 3, 6, 3]),
)
"""The three poses of the example of Brunnthaler, Schröcker & Husty (2005), as the documentation of rational-linkages
has them, with the other sign of ε: half-turns, which a Bennett linkage visits."""

BENNETT_OF_HEGEDUS = (
    DualQuaternion([0, 1, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([0, 0, 1, 0, 0, -9, 0, 9]),
    DualQuaternion([0, Fraction(-1, 3), Fraction(-2, 3), Fraction(2, 3), 0, 4, -4, -2]),
    DualQuaternion([0, Fraction(2, 3), Fraction(1, 3), Fraction(2, 3), 0, -5, -4, 7]),
)
"""The axes of a Bennett linkage, from Hegedüs, Schicho & Schröcker (2013) as the documentation of rational-linkages has
them, with the other sign of ε; the moment of the last axis follows from the others.  Its links are 9 and 3√5 long."""

PARALLELOGRAM = (
    DualQuaternion([0, 0, 0, 1, 0, 0, 0, 0]),
    DualQuaternion([0, 0, 0, 1, 0, 0, -2, 0]),
    DualQuaternion([0, 0, 0, 1, 0, 1, -3, 0]),
    DualQuaternion([0, 0, 0, 1, 0, 1, -1, 0]),
)
"""The axes of a plane 4R through the corners (0, 0), (2, 0), (3, 1), (1, 1) of a parallelogram."""

THREE_ROTATIONS = (
    DualQuaternion([0, 1, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([1, 0, Fraction(4, 5), 0, 0, Fraction(-4, 5), 0, Fraction(-4, 5)]),
    DualQuaternion([2, 0, Fraction(1, 2), Fraction(2, 3), 0, Fraction(-2, 3), 0, 0]),
)
"""The factors of a cubic motion with the quadratics t² + 1, (t − 1)² + 16/25 and (t − 2)² + 25/36: the first chain of a
6R linkage in the examples of rational-linkages, with the other sign of ε.  All six factorizations are rational."""

PLACES_OF_4R = (
    (0.0, 0.10620997505219355),
    (-0.09011417691125816, -0.19593427743198108),
    (-0.3373433587725879, -0.1674742402625168),
    (0.08175995620634387, 0.0),
)
"""Where the joints of the Bennett linkage through the third, first and second of `POSES_OF_BRUNNTHALER` sit, so that
its links do not collide, from the model ``bennett_ark24`` of rational-linkages (Huczala et al. 2024), which was
printed. In loop order, where each joint begins and where it ends: lengths along its axis, from the foot of the
origin."""

PLACES_OF_6R = (
    (-0.7253381201896022, -0.798226343812831),
    (0.5585449951, 0.4856567714),
    (0.7179258750000003, 0.6450376515000003),
    (-0.06774166896361282, 0.005146554812791664),
    (0.3894979362433264, 0.4623861596254876),
    (-0.9155332583073172, -0.8426450346840884),
)
"""The same for the angle-symmetric 6R whose first chain is `THREE_ROTATIONS`, and the second one the factorization in
reversed order, from the model ``collisions_free_6r``."""

PLANE_FOLD = (
    DualQuaternion([0, 1, 0, 0, 0, 0, 0, 0]),
    DualQuaternion([0, 0, 3, 0, 0, 0, 0, -1]),
    DualQuaternion([0, 1, 1, 0, 0, 0, 0, 2]),
)
"""The factors of a cubic motion whose 6R linkages fold into a plane at t = ∞, from the model ``plane_fold_6r`` of
rational-linkages, with the other sign of ε.  All six factorizations are rational."""

LINE_SYMMETRIC = (
    DualQuaternion([0, 1, 0, 0, 0, 0, 0, -1]),
    DualQuaternion([0, 0, 1, 0, 0, -1, 0, -1]),
    DualQuaternion([0, 0, 0, 1, 0, -1, -1, 0]),
    DualQuaternion([0, 1, 0, 0, 0, 0, 0, 1]),
    DualQuaternion([0, 0, -1, 0, 0, -1, 0, 1]),
    DualQuaternion([0, 0, 0, -1, 0, -1, 1, 0]),
)
"""The axes of a 6R linkage of Bricard's line-symmetric kind, from the examples of rational-linkages, with the other
sign of ε: the rows of links n and n + 3 are equal.  It moves, but not by linear factors."""
