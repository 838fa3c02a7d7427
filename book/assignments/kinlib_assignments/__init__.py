"""What the assignments of the book share: numbers of each student's own, and answers that are withheld.

Each assignment has a module of its name with a function ``data(student)``; `Lot` draws its numbers.
"""

from kinlib_assignments.lot import Lot, student_id
from kinlib_assignments.withhold import withheld

__all__ = ["Lot", "student_id", "withheld"]
