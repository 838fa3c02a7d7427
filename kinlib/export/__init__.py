"""Linkages for other programs: MuJoCo, URDF and rational-linkages; parts for a 3-D printer, with ``kinlib[export]``."""

from kinlib.export.mjcf import as_mjcf
from kinlib.export.printing import PrintedParts, PrintSizes, printed_parts
from kinlib.export.rational import as_rational_linkages, from_rational_linkages
from kinlib.export.urdf import as_urdf, closing_constraint, save_urdf

__all__ = [
    "PrintSizes",
    "PrintedParts",
    "as_mjcf",
    "as_rational_linkages",
    "as_urdf",
    "closing_constraint",
    "from_rational_linkages",
    "printed_parts",
    "save_urdf",
]
