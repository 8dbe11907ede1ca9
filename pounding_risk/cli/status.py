"""The command `status`: how far a study is."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pounding_risk._common.counted import counted
from pounding_risk.cli._common.options import argument
from pounding_risk.cli._common.progress import pace, span_words
from pounding_risk.render.terminal import print_pairs

if TYPE_CHECKING:
    from pounding_risk.ensemble.status import Status

ORDER = 220


def status(paths: Annotated[list[Path], argument("RESULTS...", "Results (.nc or .zarr) or a study's folder.")]) -> None:
    """Show how far a study is: running, stopped or complete."""
    from pounding_risk.ensemble.status import status as run

    for number, state in enumerate([run(path) for path in paths]):
        if number:
            print()
        print_pairs(_pairs(state))
        if state.go_on:  # never wrapped, so that it can be copied
            print(f"{'go on' if state.begun else 'begin'} with:  {state.go_on}")


def _pairs(state: Status) -> list[tuple[str, str]]:
    """Labels and words of what is known of a study."""
    shards = f"; {counted(state.shards, 'shard')} so far" if state.shards else ""
    size = f"{counted(state.parts, 'part')}, {state.size / 1e6:.1f} MB" if state.parts else ""
    cases = ""
    if state.total:
        cases = f"{state.cases} of {state.total} ({100 * state.cases // state.total} %)"
        cases += pace(state.cases_a_second, state.total - state.cases)
    pairs = [
        ("study", str(state.path)),
        ("title", state.title),
        ("state", state.state + shards),
        ("cases", cases),
        ("on disk", size),
        ("begun", _time_words(state.begun)),
        ("last activity", _time_words(state.last_activity)),
        ("note", state.note),
    ]
    return [(label, words) for label, words in pairs if words]


def _time_words(time: str) -> str:
    """A time of the log [ISO 8601], and how long ago it was; "" for no time."""
    if not time:
        return ""
    moment = datetime.fromisoformat(time)
    seconds_ago = max((datetime.now(UTC) - moment).total_seconds(), 0.0)
    return f"{moment:%Y-%m-%d %H:%M:%S} UTC, {span_words(seconds_ago)} ago"
