"""Run notebooks from top to bottom and save them: ``python book/_ext/run_notebooks.py PATH …``.

Nothing of the run but its outputs is saved, so that a second run changes nothing.
"""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient


def run(path: Path) -> None:
    """Execute a notebook in its own folder and save it in place."""
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    where = {"metadata": {"path": str(path.parent)}}
    NotebookClient(notebook, kernel_name="python3", record_timing=False, resources=where).execute()
    nbformat.write(notebook, path)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print("==", name, flush=True)
        run(Path(name))
