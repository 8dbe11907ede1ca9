"""Generated pages: the reference, from the objects of the package, the benchmarks and the tutorials.

``python docs/generate.py`` writes them to docs/generated, as ``conf.py`` does at every build. With RUN_NOTEBOOKS=1 in
the environment the notebooks are run, which takes minutes, and the tutorials have their figures.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path[:0] = [str(HERE), str(ROOT)]

from generation.assessment import assessment_page  # noqa: E402
from generation.commands import commands_page, python_page  # noqa: E402
from generation.markdown import fence  # noqa: E402
from generation.models import effects_page, laws_page, restitution_page  # noqa: E402
from generation.notebooks import notebook_pages, reading_order, tutorials  # noqa: E402
from generation.records import checks_page, formats_page, motions_page, steps_page  # noqa: E402
from generation.rules import rules_page  # noqa: E402
from generation.scenes import outputs_page, scene_page  # noqa: E402
from generation.typologies import typologies_page  # noqa: E402
from generation.verification import verification_pages  # noqa: E402


def pages(run: bool = False) -> dict[str, str | bytes]:
    """Content of every generated file by its path; with ``run`` the notebooks are run."""
    files: dict[str, str | bytes] = {
        "scene.md": scene_page(),
        "outputs.md": outputs_page(smallest_dataset()),
        "commands.md": commands_page(),
        "python.md": python_page(),
        "contact_models.md": laws_page(),
        "effects.md": effects_page(),
        "restitution.md": restitution_page(),
        "typologies.md": typologies_page(),
        "formats.md": formats_page(),
        "motions.md": motions_page(),
        "steps.md": steps_page(),
        "checks.md": checks_page(),
        "separations.md": rules_page(),
        "assessment.md": assessment_page(),
        "benchmarks.md": _with_site_links((ROOT / "benchmarks" / "README.md").read_text("utf-8")),
    }
    files |= isolated_impacts() | table_impact()
    files |= verification_pages(interpreted)
    for path in notebooks():
        files |= notebook_pages(path, run)
    files["pieces/tutorials.md"] = tutorials(notebooks())
    return files


def write(folder: Path, run: bool = False) -> None:
    """Write the files whose content has changed, and remove those that are no longer generated."""
    wanted = {name: text.encode() if isinstance(text, str) else text for name, text in pages(run).items()}
    for old in folder.rglob("*.*"):
        if old.is_file() and old.relative_to(folder).as_posix() not in wanted:
            old.unlink()
    for name, content in wanted.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != content:
            path.write_bytes(content)


def asked() -> bool:
    """True if the environment asks for the notebooks to be run."""
    return os.environ.get("RUN_NOTEBOOKS", "0") not in ("", "0")


def _with_site_links(text: str) -> str:
    """Markdown with pictures from the docs folder; links to files of the repository become their names."""
    text = re.sub(r"\]\((?:\.\./)?docs/images/", "](/images/", text)
    return re.sub(r"(?<!!)\[([^\]]+)\]\((?!https?:|/|#)[^)]+\)", lambda link: f"`{link[1].strip('`')}`", text)


def notebooks() -> list[Path]:
    """The notebooks of the repository, in reading order."""
    return sorted((ROOT / "notebooks").glob("*.ipynb"), key=reading_order)


# A scan of 0.3 s without contact.
SMALLEST = """
import json
import pounding_risk as pr
scene = pr.read_scene({scene!r}, ['records.window=["0 s", "0.3 s"]', 'interface.gap="1 m"'])
dataset = pr.scan(scene, check_fraction=1.0)
def about(variables):
    return {{name: [list(map(str, variable.dims)), variable.attrs.get("units", ""), variable.attrs.get("long_name", "")]
            for name, variable in variables.items()}}
print(json.dumps({{"variables": about(dataset.data_vars), "coordinates": about(dataset.coords),
                  "attributes": {{name: str(value) for name, value in dataset.attrs.items()}}}}))
"""


@lru_cache(maxsize=1)
def smallest_dataset() -> dict[str, dict]:
    """Variables, coordinates and attributes of a scan's dataset, from a short one."""
    scene = ROOT / "pounding_risk" / "scene" / "shipped" / "paper.toml"
    printed = interpreted("-c", SMALLEST.format(scene=str(scene)))
    return json.loads(printed.splitlines()[-1])


IMPACT = (
    *("--law kelvin_voigt", "--law kelvin_voigt_tension_cut", "--law modified_kelvin_voigt", "--law hertz_damp"),
    *("--law jankowski", "--law viscous_elastoplastic", '--stiffness "9.35e7 N/m"', '--stiffness "2.75e9 N/m^1.5"'),
    *('--yield-force "70 kN"',),
)
IMPACT_CAPTION = "Contact force against time and against penetration under six contact laws"


TABLE_IMPACT = (
    *("--law tabulated", "--table bumper.csv", "--law linear", '--stiffness "20 MN/m"', '--mass "5 t"'),
    '--speed "1.5 m/s"',
)
TABLE_CAPTION = "Contact force of a tabulated bumper and of a spring of its stiffness; the bumper is left crushed"


def isolated_impacts() -> dict[str, str | bytes]:
    """One impact under six laws: the command, its output and its figure."""
    return _impact("isolated-impacts", "laws.png", IMPACT, IMPACT_CAPTION)


def table_impact() -> dict[str, str | bytes]:
    """One impact on the bumper of the examples."""
    return _impact("table-impact", "table.png", TABLE_IMPACT, TABLE_CAPTION)


def _impact(piece: str, picture: str, options: Sequence[str], caption: str) -> dict[str, str | bytes]:
    """A command `impact` with its output and its figure; tables are those of the examples."""
    with TemporaryDirectory() as folder:
        target = Path(folder) / picture
        words = ["impact", *shlex.split(" ".join(options)), "--figure", str(target)]
        printed = interpreted("-m", "pounding_risk", *words, folder=HERE / "examples")
        drawn = target.read_bytes()
    command = " \\\n    ".join(["pounding-risk impact", *options, f"--figure {picture}"])
    table = printed.rpartition("written:")[0]
    text = f"{fence(command, 'sh')}\n{fence(table)}\n![{caption}](/generated/{picture})\n"
    return {picture: drawn, f"pieces/{piece}.md": text}


def interpreted(*arguments: str, compiled: bool = False, folder: Path | None = None) -> str:
    """Output of Python with these arguments; not ``compiled`` where compilation would take longer than it saves."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    if not compiled:
        environment["NUMBA_DISABLE_JIT"] = "1"
    command = [sys.executable, *arguments]
    limit = 600 if compiled else 120
    run = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=limit)
    if run.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{run.stderr}")
    return run.stdout


if __name__ == "__main__":
    write(HERE / "generated", run=asked())
