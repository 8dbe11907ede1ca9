"""Pages of the notebooks: text and code cells and, if they are run, outputs and figures."""

from __future__ import annotations

import json
from base64 import b64decode
from collections.abc import Sequence
from pathlib import Path
from shutil import copy
from tempfile import TemporaryDirectory
from typing import Any

from generation.markdown import fence

# The order of the tutorials; other notebooks follow.
FIRST = (
    "paper",
    "gap_adequacy",
    "gap_not_enough",
    "uncertain_buildings",
    "pounding_spectra",
    "comparing_models",
    "city_block",
    "district",
    "rows_study",
    "code_gaps",
    "contact_law_matters",
    "contact_law_papers",
    "accuracy_against_time",
)
TIME_LIMIT = 900  # s a cell: the first run of a law compiles it


def reading_order(path: Path) -> tuple[int, str]:
    """Sort key of a notebook."""
    return FIRST.index(path.stem) if path.stem in FIRST else len(FIRST), path.stem


def tutorials(paths: Sequence[Path]) -> str:
    """List of the notebooks with title, link and first paragraph."""
    entries = []
    for path in paths:
        title, _, rest = "".join(_cells(path)[0]["source"]).partition("\n")
        first = rest.strip().partition("\n\n")[0]
        entries.append(f"## [{title.lstrip('# ')}](generated/notebooks/{path.stem}.md)\n\n{first}\n")
    listed = "\n".join(f"generated/notebooks/{path.stem}" for path in paths)
    return "\n".join([*entries, f"```{{toctree}}\n:hidden:\n\n{listed}\n```\n"])


def notebook_pages(path: Path, run: bool = False) -> dict[str, str | bytes]:
    """The page and the pictures of a notebook by their paths. Notebooks are stored without outputs."""
    cells = _executed(path) if run else _cells(path)
    pictures: dict[str, str | bytes] = {}
    body = [_cell(cell, path.stem, pictures) for cell in cells]
    source = f"This is `notebooks/{path.name}` of the repository{'' if run else ', without outputs'}.\n"
    title, rest = body[0].split("\n", 1)
    return {f"notebooks/{path.stem}.md": "\n\n".join([title, source, rest, *body[1:]]), **pictures}


def _cells(path: Path) -> list[Any]:
    return json.loads(path.read_text("utf-8"))["cells"]


def _executed(path: Path) -> list[Any]:
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as folder:  # for files that its cells write, with the scenes that it reads
        for scene in path.parent.glob(f"{path.stem}*.toml"):
            copy(scene, folder)
        where = {"metadata": {"path": folder}}
        return NotebookClient(notebook, timeout=TIME_LIMIT, kernel_name="python3", resources=where).execute().cells


def _cell(cell: Any, stem: str, pictures: dict[str, str | bytes]) -> str:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return source + "\n"
    outputs = (_output(output, stem, pictures) for output in cell["outputs"])
    return "\n".join([fence(source, "python"), *filter(None, outputs)])


def _output(output: Any, stem: str, pictures: dict[str, str | bytes]) -> str:
    """Output of a cell as Markdown; a picture is added to ``pictures``."""
    if output["output_type"] == "stream":
        return fence("".join(output["text"]))
    data = output.get("data", {})
    if "image/png" not in data:
        return fence("".join(data["text/plain"])) if "text/plain" in data else ""
    name = f"notebooks/{stem}-{len(pictures) + 1}.png"
    pictures[name] = b64decode(data["image/png"])
    return f"![Figure {len(pictures)} of the notebook, which the text before it describes](/generated/{name})\n"
