"""What all tests and doctests share, and the order in which they run."""

import os
import re

import pytest

import kinlib

DEAR = {"chromium", "html", "grade", "grade_as_teachers_do"}  # fixtures: a browser, the built book, a kernel
LONG = ("book/assignments", "page ", "tests/test_scene", "tests/test_book", "tests/test_goldberg", "tests/test_six_r")
PAGE = re.compile(r"\[(.+\.html)\]$")


def needs_the_book(item) -> bool:
    """Whether a test needs the built book, a browser or a kernel."""
    return item.path.is_relative_to(item.config.rootpath / "book") or bool(
        DEAR & set(getattr(item, "fixturenames", ()))
    )


def group_of(name: str) -> str:
    """What a test shares with its neighbours: a page that is open, a kernel, or what its module or class has made."""
    page = PAGE.search(name)
    return f"page {page[1]}" if page else name.rpartition("::")[0]


def rank(group: str) -> int:
    """What takes long begins first, so that no worker is left with it at the end."""
    return next((n for n, start in enumerate(LONG) if group.startswith(start)), len(LONG))


def pytest_collection_modifyitems(items):
    """Mark what needs the book, and put each group together."""
    for item in items:
        if needs_the_book(item):
            item.add_marker(pytest.mark.book)
    groups = [group_of(item.nodeid) for item in items]
    first = {group: n for n, group in reversed(list(enumerate(groups)))}
    items.sort(key=lambda item: (rank(group_of(item.nodeid)), first[group_of(item.nodeid)]))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Several workers share the groups, in this order; none is divided."""
    from xdist.scheduler import LoadScopeScheduling

    class Groups(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return group_of(nodeid)

    config.option.loadscopereorder = False
    return Groups(config, log)


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
