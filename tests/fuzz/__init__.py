"""The fuzz: very many seeded problems, good and nearly degenerate, whose answers are judged without kinlib.

``python -m tests.fuzz`` runs it and prints a table; ``--help`` tells the rest.
"""
