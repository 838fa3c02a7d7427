"""Measure everything and print the table."""

import sys

from .table import BUDGET, SIZE, as_text, machine, table

rows = table()
print("\r\033[K", end="", file=sys.stderr)
print(f"{machine()}; one thread, batches of {SIZE:,}; the least of what fits in {BUDGET:g} s a row\n")
print(as_text(rows))
