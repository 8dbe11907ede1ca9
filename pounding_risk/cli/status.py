"""The command `status`: how far a study is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.progress import pace, span_words
from pounding_risk.cli._common.tables import print_pairs

if TYPE_CHECKING:
    from pounding_risk.ensemble.status import Status

ORDER = 220


def status(
    paths: Annotated[
        list[Path],
        typer.Argument(metavar="RESULTS...", help="Results (.nc or .zarr) or a study's folder.", show_default=False),
    ],
) -> None:
    """Show how far a study is: running, stopped or complete."""
    from pounding_risk.ensemble.status import status as run

    for place, found in enumerate([run(path) for path in paths]):
        if place:
            typer.echo()
        print_pairs(rows(found))
        if found.go_on:  # never broken in two, so that it can be copied
            typer.echo(f"{'go on' if found.begun else 'begin'} with:  {found.go_on}")


def rows(found: Status) -> list[tuple[str, str]]:
    """What is known of a study, one pair a line."""
    shards = f"; {found.shards} shard{'s' * (found.shards != 1)} so far" if found.shards else ""
    told = [
        ("study", str(found.path)),
        ("title", found.title),
        ("state", found.state + shards),
        ("cases", _cases(found)),
        ("on disk", f"{found.parts} part{'s' * (found.parts != 1)}, {found.size / 1e6:.1f} MB" if found.parts else ""),
        ("begun", _when(found.begun)),
        ("last activity", _when(found.last_activity)),
        ("note", found.note),
    ]
    return [(what, words) for what, words in told if words]


def _cases(found: Status) -> str:

    if not found.total:
        return ""
    share = f"{found.cases} of {found.total} ({100 * found.cases // found.total} %)"
    return share + pace(found.cases_a_second, found.total - found.cases)


def _when(time: str) -> str:
    """A time of the log, and how long ago that is."""
    from datetime import UTC, datetime

    if not time:
        return ""
    then = datetime.fromisoformat(time)
    ago = max((datetime.now(UTC) - then).total_seconds(), 0.0)
    return f"{then:%Y-%m-%d %H:%M:%S} UTC, {span_words(ago)} ago"
