"""What all tests and doctests share."""

import os

import pytest

import kinlib


@pytest.fixture(autouse=True)
def _units(doctest_namespace):
    """Docstring examples may use the units by their names."""
    for name in ("one", "i", "j", "k", "eps"):
        doctest_namespace[name] = getattr(kinlib, name)


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session):
    """With KINLIB_NO_SKIPS set, a skipped test fails the run."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    skipped = reporter.stats.get("skipped", []) if reporter else []
    if os.environ.get("KINLIB_NO_SKIPS") and skipped:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    skipped = terminalreporter.stats.get("skipped", [])
    if os.environ.get("KINLIB_NO_SKIPS") and skipped:
        terminalreporter.write_line(f"KINLIB_NO_SKIPS is set and {len(skipped)} tests were skipped", red=True)
