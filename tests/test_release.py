"""What is written in several files agrees: versions, and the packages that are asked for and pinned."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

import kinlib

ROOT = Path(__file__).resolve().parents[1]


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


PROJECT = tomllib.loads(text("pyproject.toml"))
LOCK = dict(re.findall(r"^([\w.-]+)==(\S+)", text("requirements.lock"), re.MULTILINE))
LOCKED = re.findall(r"--extra (\w+)", text("requirements.lock"))


@pytest.mark.parametrize(
    ("file", "pattern"),
    [
        ("CITATION.cff", r"^version: (\S+)$"),
        ("CHANGELOG.md", r"\A.*?^## (\S+)"),
        ("book/assignments/teaching.md", r"kinlib-(\d\S*?)-py3-none-any\.whl"),
    ],
)
def test_the_version_is_that_of_the_package(file, pattern):
    found = re.findall(pattern, text(file), re.MULTILINE | re.DOTALL)
    assert set(found) == {kinlib.__version__}


def test_the_version_stands_in_the_package_alone():
    assert "version" in PROJECT["project"]["dynamic"]
    assert PROJECT["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "kinlib.__version__"}
    assert str(Version(kinlib.__version__)) == kinlib.__version__


def test_pre_commit_has_the_ruff_that_is_locked():
    assert re.findall(r"ruff-pre-commit\n +rev: v(\S+)", text(".pre-commit-config.yaml")) == [LOCK["ruff"]]


@pytest.mark.parametrize("extra", [None, *LOCKED])
def test_the_lock_gives_what_the_project_asks_for(extra):
    lists = PROJECT["project"]
    asked = lists["dependencies"] if extra is None else lists["optional-dependencies"][extra]
    wanted = [requirement for requirement in map(Requirement, asked) if requirement.name != "kinlib"]
    assert [str(r) for r in wanted if not r.specifier.contains(LOCK.get(r.name.lower(), "0"))] == []
