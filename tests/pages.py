"""The sources of the book and its built pages."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HTML = ROOT / "_build" / "html"


def found(folder: Path, pattern: str) -> list[Path]:
    """The files below a folder, but for what Jupyter and Sphinx put there for themselves."""
    own = {".ipynb_checkpoints", "_static"}
    return sorted(path for path in folder.rglob(pattern) if not own & set(path.relative_to(folder).parts))


TEXTS = found(ROOT / "book", "*.md")
NOTEBOOKS = [path for path in found(ROOT / "book", "*.ipynb") if "release" not in path.parts]
PAGES = [path.relative_to(HTML).as_posix() for path in found(HTML, "*.html")]
SCENES = [page for page in PAGES if 'class="kinlib-scene"' in (HTML / page).read_text(encoding="utf-8")]
