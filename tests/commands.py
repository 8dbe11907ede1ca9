"""Commands in this very process, and the tables that they print."""

from __future__ import annotations

import re
from typing import Any

from scenes import FRAME, scene_text, single
from typer.testing import CliRunner

from pounding_risk import cli

SCENE = scene_text(
    FRAME,
    single("masonry", "82.60 t", "0.1 s"),
    name="A pair",
    law="hertz",
    gap="0 mm",
    records={"window": ["0 s", "3 s"], "pga": "0.5 g"},
    grid={"gap": ["0 mm", "5 mm", "1 m"], "yield_force": ["200 kN", "inf"]},
)


def run(*words: object, **settings: Any) -> Any:
    """What a command prints, and its exit status; ``settings`` are those of click's runner, such as ``env``."""
    return CliRunner().invoke(cli.app, list(map(str, words)), prog_name="pounding-risk", **settings)


def done(*words: object, **settings: Any) -> Any:
    """What a command prints that must come to its end."""
    result = run(*words, **settings)
    assert result.exit_code == 0, result.output
    return result


def refused(*words: object) -> str:
    """The sentence of a command that ends with status 2, without a traceback."""
    done = run(*words)
    assert done.exit_code == 2 and "Traceback" not in done.output, done.output
    return done.stderr


def rows(text: str) -> list[list[str]]:
    """The cells of printed tables: columns are two spaces apart at least."""
    return [re.split(r" {2,}", line.strip()) for line in text.splitlines() if line.strip()]
