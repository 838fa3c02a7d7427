"""What all tests and doctests share, and the order in which they run."""

import os

import pytest

import kinlib

DEAR = {"chromium", "html", "grade", "grade_as_teachers_do"}  # fixtures: a browser, the built book, a kernel
LONG = ("book/assignments", "page ", "tests/test_scene", "tests/test_book", "tests/test_goldberg", "tests/test_six_r")


def needs_the_book(item) -> bool:
    """Whether a test needs the built book, a browser or a kernel."""
    return item.path.is_relative_to(item.config.rootpath / "book") or bool(
        DEAR & set(getattr(item, "fixturenames", ()))
    )


def group_of(item) -> str:
    """What a test shares with its neighbours: an open page, a kernel, or what its module or class has made."""
    if "look" in getattr(item, "fixturenames", ()) and hasattr(item, "callspec"):
        return f"page {item.callspec.params['name']}"
    return item.nodeid.rpartition("::")[0]


def rank(group: str) -> int:
    """What takes long begins first, so that no worker is left with it at the end."""
    return next((n for n, start in enumerate(LONG) if group.startswith(start)), len(LONG))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Keep together what shares something, also where several workers share the tests."""
    groups = {item: group_of(item) for item in items}
    for item, group in groups.items():
        item.add_marker(pytest.mark.xdist_group(group))
        if needs_the_book(item):
            item.add_marker(pytest.mark.book)
    order = {group: n for n, group in enumerate(dict.fromkeys(groups.values()))}
    items.sort(key=lambda item: (rank(groups[item]), order[groups[item]]))


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
