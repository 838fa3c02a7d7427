# Everything runs in .venv, which the first command makes from requirements.lock.
# After that no command needs the network.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
NOTEBOOK ?= $(shell find book -name '*.ipynb' -not -path '*/.*' -not -path 'book/assignments/*' 2>/dev/null | sort)
PAGE := _build/html/index.html

export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PATH := $(abspath $(BIN)):$(PATH)

.PHONY: help setup book check test claims fuzz bench note notebooks assignments grade lint types clean distclean

help:
	@echo "make book       build the book and say which file to open"
	@echo "make check      check style, types and code: two minutes, for each change"
	@echo "make test       all of that, build the book, then check notebooks and pages"
	@echo "make claims     print the exact ranks of all kinds of data, and solve TABLE=2 problems a row of the table of tasks again"
	@echo "make fuzz       try many thousands of problems (FUZZ='--triples 3000' for fewer)"
	@echo "make bench      measure speed and print the table"
	@echo "make note       write the research note, of the book's own statements and proofs"
	@echo "make notebooks  run and save every notebook (NOTEBOOK=path for one)"
	@echo "make assignments  make the students' copies of the assignments"
	@echo "make grade SUBMISSIONS=folder  grade what students handed in (OUT=graded)"
	@echo "make clean      remove what was built"
	@echo "make distclean  remove .venv as well"

setup: $(VENV)/.installed

$(VENV)/.locked: requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "kinlib needs Python 3.11 or newer; try make PYTHON=python3.12")'
	@echo "== Setting up $(VENV) (a minute or two, once)"
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --requirement requirements.lock
	touch $@

$(VENV)/.installed: $(VENV)/.locked pyproject.toml book/assignments/pyproject.toml
	@echo "== Installing kinlib and kinlib-assignments"
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable . --editable book/assignments
	touch $@

# Built from nothing each time: a page that was not read again would keep its warnings to itself.
book: setup
	@echo "== Building the book"
	rm -rf _build
	$(BIN)/jupyter-book build -W -n --keep-going .
	@echo
	@echo "Open $(abspath $(PAGE))"

lint: setup
	@echo "== Checking style"
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: setup
	@echo "== Checking types"
	$(BIN)/mypy

# Each worker takes what belongs together: a page that is open, a notebook's kernel, a module; see conftest.py.
PYTEST := $(BIN)/python -m pytest -n auto --maxprocesses=4

check: lint types
	@echo "== Testing code"
	$(PYTEST) -p no:nbval -m "not book" tests kinlib

test: check book
	@echo "== Testing notebooks and pages"
	$(PYTEST) -m book --ignore=book/assignments/release \
	    --nbval --nbval-current-env --nbval-cell-timeout=120 --nbval-sanitize-with=tests/nbval_sanitize.cfg \
	    tests book

# The ranks stand in the tests as well; the table, made once, is too long for them.
TABLE ?= 2

claims: setup
	@echo "== Exact ranks for all kinds of data"
	$(BIN)/python -m tests.exact_count
	@echo "== The table of tasks"
	$(BIN)/python -m tests.task_table --check $(TABLE)

FUZZ ?=

fuzz: setup
	$(BIN)/python -m tests.fuzz $(FUZZ)

bench: setup
	$(BIN)/python -m tests.bench

# The PDF needs TeX: Debian's texlive-latex-extra, texlive-fonts-recommended, lmodern and latexmk.
note: setup
	rm -rf _build/note
	$(BIN)/sphinx-build -q -W -b latex book/note _build/note
	@echo "The source is _build/note/note.tex"
	@if command -v latexmk >/dev/null; then cd _build/note && latexmk -pdf -interaction=nonstopmode note.tex >latexmk.log && echo "Open $(abspath _build/note/note.pdf)"; fi

notebooks: setup
	$(BIN)/ruff format --quiet $(NOTEBOOK)
	$(BIN)/python book/_ext/run_notebooks.py $(NOTEBOOK)

SOLVED := $(wildcard book/assignments/source/*/*.ipynb)

assignments: setup
	$(BIN)/ruff format --quiet $(SOLVED)
	$(BIN)/python book/_ext/run_notebooks.py $(SOLVED)
	$(BIN)/python book/assignments/release.py

OUT ?= graded
GRADING ?=

grade: setup
	@test -n "$(SUBMISSIONS)" || { echo "say which folder: make grade SUBMISSIONS=folder"; exit 2; }
	@PYTHONPATH=book/assignments $(BIN)/python -m grader "$(SUBMISSIONS)" --out "$(OUT)" $(GRADING)

clean:
	rm -rf _build build dist kinlib.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	rm -rf book/assignments/build book/assignments/kinlib_assignments.egg-info
	find kinlib tests book -name __pycache__ -type d -exec rm -rf {} +

distclean: clean
	rm -rf $(VENV)
