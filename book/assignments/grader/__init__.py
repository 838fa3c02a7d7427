"""Grades a folder of submissions: ``python -m grader FOLDER`` in book/assignments, or ``make grade``."""
