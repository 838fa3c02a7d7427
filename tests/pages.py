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

# The scenes of the book, page by page, in their order, by the names of their figures.
SCENES = {
    "book/index.html": ["fig-hero"],
    "book/start/results.html": ["fig-results-scene"],
    "book/start/why_it_moves.html": ["fig-why-five", "fig-why-flat", "fig-why-bennett", "fig-why-goldberg"],
    "book/start/your_three_poses.html": ["fig-your-three", "fig-your-five"],
    "book/preliminaries/dual_quaternions.html": ["fig-order-matters"],
    "book/preliminaries/displacements.html": ["fig-screw"],
    "book/preliminaries/study_quadric.html": ["fig-sleeve", "fig-sleeve-drag"],
    "book/preliminaries/lines_and_rotations.html": ["fig-rod-and-hinge", "fig-turn-drag"],
    "book/dyads/two_r_dyads.html": ["fig-dyad-scene", "fig-dyad-drag"],
    "book/dyads/null_quadrilaterals.html": ["fig-conic-drag"],
    "book/dyads/projection_lemmas.html": ["fig-reflections-drag", "fig-dilatations-drag"],
    "book/dyads/characterisation.html": ["fig-recognised-dyad"],
    "book/synthesis/three_poses.html": ["fig-two-dyads", "fig-two-become-one", "fig-double-root-drag"],
    "book/synthesis/bennett.html": ["fig-bennett-scene", "fig-bennett-drag"],
    "book/synthesis/factorization.html": ["fig-six-bars", "fig-exchange-drag"],
    "book/synthesis/four_poses_6r.html": ["fig-6r-scene", "fig-6r-other", "fig-free-number-drag"],
    "book/synthesis/twisted_cubics.html": ["fig-cubics-drag"],
    "book/synthesis/goldberg_5r.html": [
        "fig-goldberg-scene", "fig-goldberg-built", "fig-goldberg-eight", "fig-goldberg-drag", "fig-own-scene",
    ],
    "book/synthesis/goldberg_conditions.html": ["fig-turning-swinging", "fig-goldberg-plane-drag"],
    "book/synthesis/three_and_a_half_poses.html": ["fig-dyad-tour", "fig-five-poses"],
    "book/beyond/bonds.html": ["fig-bonds-scene"],
    "book/beyond/bars_that_pass.html": ["fig-bars-free", "fig-bars-shifted"],
    "book/beyond/map_of_all_5r.html": ["fig-map", "fig-best-worst"],
    "book/beyond/what_to_ask_of_a_5r.html": [
        "fig-ask-scene", "fig-ask-lines", "fig-ask-path", "fig-ask-camera", "fig-ask-follow",
    ],
    "book/beyond/a_linkage_you_have.html": ["fig-have-scene"],
    "book/beyond/drive_and_build.html": ["fig-drive-linkage"],
}  # fmt: skip

# Those among them that a reader can change.
EXPLORABLE = {
    "fig-hero", "fig-sleeve-drag", "fig-turn-drag", "fig-dyad-drag", "fig-conic-drag", "fig-reflections-drag",
    "fig-dilatations-drag", "fig-double-root-drag", "fig-bennett-drag", "fig-exchange-drag", "fig-free-number-drag",
    "fig-cubics-drag", "fig-goldberg-drag", "fig-own-scene", "fig-goldberg-plane-drag", "fig-map", "fig-ask-follow",
}  # fmt: skip
