"""Sphinx's settings for the research note, which is made of the book's own cells: see ``make note``."""

import sys
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE))
BOOK = yaml.safe_load((HERE.parents[1] / "_config.yml").read_text(encoding="utf-8"))["sphinx"]["config"]


def command(name: str, meaning: str | list) -> str:
    """A macro of the book's formulas as LaTeX has it."""
    text, count = meaning if isinstance(meaning, list) else (meaning, 0)
    # A backslash and a letter that LaTeX uses already (\P, \H) is given the book's meaning.
    return rf"\providecommand{{\{name}}}{{}}\renewcommand{{\{name}}}[{count}]{{{text}}}"


KINDS = "theorem", "lemma", "proposition", "definition", "remark"
THEOREMS = [
    rf"\newtheorem{{{kind}}}{'' if kind == 'theorem' else '[theorem]'}{{{kind.capitalize()}}}" for kind in KINDS
]

GREEK = {"α": "alpha", "β": "beta", "λ": "lambda", "μ": "mu", "τ": "tau", "φ": "varphi", "ω": "omega"}  # in listings
LETTERS = [
    rf"\DeclareUnicodeCharacter{{{ord(letter):04X}}}{{\ensuremath{{\{name}}}}}" for letter, name in GREEK.items()
]

project = "What to ask of a 5R linkage"
author = "The kinlib developers"
root_doc = "index"
exclude_patterns = []
extensions = ["myst_parser", "sphinxcontrib.bibtex", "cells"]
myst_enable_extensions = ["amsmath", "dollarmath", "attrs_inline"]
bibtex_bibfiles = ["../references.bib"]
bibtex_default_style = BOOK["bibtex_default_style"]
bibtex_reference_style = BOOK["bibtex_reference_style"]
numfig = True
latex_engine = "pdflatex"
latex_docclass = {"howto": "article"}
latex_documents = [("index", "note.tex", project, author, "howto")]

latex_elements = {
    "preamble": "\n".join(
        [
            r"\usepackage{amsthm}",
            r"\usepackage{cleveref}",
            r"\fvset{fontsize=\scriptsize}",
            *THEOREMS,
            *LETTERS,
            *(command(*item) for item in BOOK["mathjax3_config"]["tex"]["macros"].items()),
        ]
    ),
    "fncychap": "",
    "geometry": r"\usepackage[margin=23mm]{geometry}",
    "fontpkg": r"\usepackage{lmodern}",
    "figure_align": "htbp",
    "tableofcontents": "",
    "papersize": "a4paper",
    "printindex": "",
    "sphinxsetup": "verbatimwithframe=false, VerbatimColor={rgb}{0.96,0.96,0.96}",
}
