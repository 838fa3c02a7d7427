"""The algebra of 2R dyads by name, and 4R, 5R and 6R linkages from poses.

A name's file is read when the name is first asked for (PEP 562), so that a program waits only for what it uses.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # what checkers of types and editors read; the same as below
    from kinlib import task
    from kinlib.bennett import bennett_linkage
    from kinlib.bonds import Bond
    from kinlib.brief import Brief, ZGrid
    from kinlib.chain import Chain, DHRow
    from kinlib.collision import Collision, CollisionFault, Collisions
    from kinlib.displacement import (
        act,
        as_matrix,
        as_rigid_transform,
        axis_of,
        from_matrix,
        from_rigid_transform,
        half_turn,
        rotation,
        translation,
        unit,
    )
    from kinlib.dual_quaternion import DualQuaternion, eps, i, j, k, null_form, one, study_form
    from kinlib.dyad import Dyad, NullQuadrilateral, TwoRSpace, primal_coordinates, recognise
    from kinlib.errors import DegenerateError, NotFoundError
    from kinlib.factorization import bennett_flip, exchange, factorizations, factorize, quadratic_of
    from kinlib.goldberg import goldberg_linkages, goldberg_linkages_with_stops
    from kinlib.interpolation import Families, conic_through, cubics_through, fourth_parameters
    from kinlib.line import Line, common_perpendicular
    from kinlib.linkage import Linkage
    from kinlib.linkage_search import Choice, refine, search
    from kinlib.motion_polynomial import MotionPolynomial, RationalCurve, linear_factor
    from kinlib.number_field import NumberField, NumberFieldElement, square_root
    from kinlib.poses import as_pose
    from kinlib.projective import Subspace, join, meet, null_space, same_point
    from kinlib.quadratics import quadratic_factors
    from kinlib.quadric import Quadric, binary_roots
    from kinlib.reach import NearestPose
    from kinlib.scalar import as_float, as_scalars, divide, is_exact, is_zero, size
    from kinlib.six_r import ADMISSIBLE_PAIRS, six_r_linkages
    from kinlib.study import (
        EXCEPTIONAL_SPACE,
        NULL_CONE,
        STUDY_QUADRIC,
        is_null_line,
        study_projection,
    )
    from kinlib.surface import NearestStop, nearest_stop, stops_on_line
    from kinlib.task_follow import follow
    from kinlib.task_linkages import bennett_linkages_for, goldberg_linkages_for, six_r_linkages_for
    from kinlib.three_poses import dyads_through_poses, study_eigenvalues
    from kinlib.timetable import ConstantPointSpeed, ConstantSpeed, RestAtPoses, Timetable
    from kinlib.tolerance import Spread, spread_under_errors
    from kinlib.z_plane import ZFault, ZPlane, z_planes

__all__ = [
    "ADMISSIBLE_PAIRS",
    "EXCEPTIONAL_SPACE",
    "NULL_CONE",
    "STUDY_QUADRIC",
    "Bond",
    "Brief",
    "Chain",
    "Choice",
    "Collision",
    "CollisionFault",
    "Collisions",
    "ConstantPointSpeed",
    "ConstantSpeed",
    "DHRow",
    "DegenerateError",
    "DualQuaternion",
    "Dyad",
    "Families",
    "Line",
    "Linkage",
    "MotionPolynomial",
    "NearestPose",
    "NearestStop",
    "NotFoundError",
    "NullQuadrilateral",
    "NumberField",
    "NumberFieldElement",
    "Quadric",
    "RationalCurve",
    "RestAtPoses",
    "Spread",
    "Subspace",
    "Timetable",
    "TwoRSpace",
    "ZFault",
    "ZGrid",
    "ZPlane",
    "act",
    "as_float",
    "as_matrix",
    "as_pose",
    "as_rigid_transform",
    "as_scalars",
    "axis_of",
    "bennett_flip",
    "bennett_linkage",
    "bennett_linkages_for",
    "binary_roots",
    "common_perpendicular",
    "conic_through",
    "cubics_through",
    "divide",
    "dyads_through_poses",
    "eps",
    "exchange",
    "factorizations",
    "factorize",
    "follow",
    "fourth_parameters",
    "from_matrix",
    "from_rigid_transform",
    "goldberg_linkages",
    "goldberg_linkages_for",
    "goldberg_linkages_with_stops",
    "half_turn",
    "i",
    "is_exact",
    "is_null_line",
    "is_zero",
    "j",
    "join",
    "k",
    "linear_factor",
    "meet",
    "nearest_stop",
    "null_form",
    "null_space",
    "one",
    "primal_coordinates",
    "quadratic_factors",
    "quadratic_of",
    "recognise",
    "refine",
    "rotation",
    "same_point",
    "search",
    "six_r_linkages",
    "six_r_linkages_for",
    "size",
    "spread_under_errors",
    "square_root",
    "stops_on_line",
    "study_eigenvalues",
    "study_form",
    "study_projection",
    "task",
    "translation",
    "unit",
    "z_planes",
]
__version__ = "0.1.0"

_NAMES_IN = {
    "bennett": "bennett_linkage",
    "bonds": "Bond",
    "brief": "Brief ZGrid",
    "chain": "Chain DHRow",
    "collision": "Collision CollisionFault Collisions",
    "displacement": (
        "act as_matrix as_rigid_transform axis_of from_matrix from_rigid_transform half_turn rotation translation unit"
    ),
    "dual_quaternion": "DualQuaternion eps i j k null_form one study_form",
    "dyad": "Dyad NullQuadrilateral TwoRSpace primal_coordinates recognise",
    "errors": "DegenerateError NotFoundError",
    "factorization": "bennett_flip exchange factorizations factorize quadratic_of",
    "goldberg": "goldberg_linkages goldberg_linkages_with_stops",
    "interpolation": "Families conic_through cubics_through fourth_parameters",
    "line": "Line common_perpendicular",
    "linkage": "Linkage",
    "linkage_search": "Choice refine search",
    "motion_polynomial": "MotionPolynomial RationalCurve linear_factor",
    "number_field": "NumberField NumberFieldElement square_root",
    "poses": "as_pose",
    "projective": "Subspace join meet null_space same_point",
    "quadratics": "quadratic_factors",
    "quadric": "Quadric binary_roots",
    "reach": "NearestPose",
    "scalar": "as_float as_scalars divide is_exact is_zero size",
    "six_r": "ADMISSIBLE_PAIRS six_r_linkages",
    "study": "EXCEPTIONAL_SPACE NULL_CONE STUDY_QUADRIC is_null_line study_projection",
    "surface": "NearestStop nearest_stop stops_on_line",
    "task_follow": "follow",
    "task_linkages": "bennett_linkages_for goldberg_linkages_for six_r_linkages_for",
    "three_poses": "dyads_through_poses study_eigenvalues",
    "timetable": "ConstantPointSpeed ConstantSpeed RestAtPoses Timetable",
    "tolerance": "Spread spread_under_errors",
    "z_plane": "ZFault ZPlane z_planes",
}
_FILE_OF = {name: file for file, names in _NAMES_IN.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    """A public name, or the door `task`, from its file."""
    if name == "task":
        return import_module("kinlib.task")
    if name not in _FILE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f"kinlib.{_FILE_OF[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
