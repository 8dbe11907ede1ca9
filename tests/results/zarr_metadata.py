"""Metadata of a Zarr store changed as a damaged one has them: in a file of their own and among those of all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def changed(store: Path, document: str, **entries: Any) -> None:
    """Change entries of a document; ``...`` takes one away."""
    every = json.loads((store / ".zmetadata").read_text())
    facts = every["metadata"][document] | entries
    every["metadata"][document] = {key: value for key, value in facts.items() if value is not ...}
    (store / ".zmetadata").write_text(json.dumps(every))
    (store / document).write_text(json.dumps(every["metadata"][document]))
