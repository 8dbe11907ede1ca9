"""The demo: figures, datasets, scenes and a report of the pair of the 2011 paper and of a small ensemble."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from pounding_risk import figures
from pounding_risk._common.written import write_file
from pounding_risk.reports import report
from pounding_risk.results.files import save


def demo(folder: str | Path = "pounding-demo", say: Callable[[str], None] = print) -> dict[str, Path]:
    """Run the example of the 2011 paper and a small ensemble, and write figures, datasets, scenes and a report.

    Parameters
    ----------
    folder : str or Path
        Where to write; it is made where it does not exist.
    say : callable
        Called with each line of the findings.

    Returns
    -------
    dict of str to Path
        The files that were written, by name.
    """
    from pounding_risk.studies import demo as runs  # compiled

    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    study = runs.scene("paper")
    damping = " and ".join(f"{100.0 * ratio:g} %" for ratio in sorted({one.damping for one in study.buildings}))
    assumed = f"{damping} damping and F_E = {study.yield_force / 1e3:.0f} kN are not published, but assumed"
    say(f"The pair of Khatiwada et al. (2011) under El Centro 1940 at 0.5 g; {assumed}.")
    say("A first run compiles the solver, which takes some twenty seconds.")
    elastic, plastic = runs.figure_8(study)
    for line in runs.pair_findings(elastic, plastic):
        say(line)
    window = runs.window(study)
    for line in runs.window_findings(window):
        say(line)
    ensemble = runs.scan(runs.scene("ensemble"))
    for line in runs.ensemble_findings(ensemble):
        say(line)
    pictures = {
        "paper.png": figures.comparison_figure([elastic, plastic], note=assumed.replace("F_E", "$F_E$")),
        "impacts.png": figures.impact_figure(runs.figure_4(), note=runs.STRIKER_NOTE),
        "yield_force.png": figures.scan_figure(window.searched, note=f"{damping} damping assumed"),
        "map.png": figures.scan_figure(ensemble, note=f"{damping} damping assumed"),
        "ratio.png": figures.ratio_figure(ensemble, note=f"{damping} damping assumed"),
    }
    written = {name: figures.write(figure, target / name) for name, figure in pictures.items()}
    for name, dataset in {"paper.nc": plastic, "yield_force.nc": window.searched, "ensemble.nc": ensemble}.items():
        written[name] = save(dataset, target / name)
    written["report.html"] = report(written["ensemble.nc"], target / "report.html")
    say(f"Next: change {_scene_file(target, 'ensemble')} to your own pair, and `pounding-risk scan` it.")
    return written | {f"{name}.toml": _scene_file(target, name) for name in ("paper", "ensemble")}


def _scene_file(folder: Path, name: str) -> Path:
    """A scene of the package as a file to change; one that is there may have been changed, and is not replaced."""
    from pounding_risk.studies import demo as runs

    file = folder / f"{name}.toml"
    if not file.exists():
        write_file(file, runs.text_of(name))
    return file
