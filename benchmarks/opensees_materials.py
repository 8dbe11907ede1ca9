"""How the impact materials of OpenSees converge to the laws of this package with its step, as a figure.

    python benchmarks/opensees_materials.py --figure docs/images/opensees_materials.png

The pair of ``side_by_side.py --quick``: 0.5 and 1.0 s, gap 20 mm, six seconds of El Centro. Errors are those of the
peak contact force and of the peak relative displacement against this package at a tolerance of 1e-12. Half a minute.
"""

from __future__ import annotations

import argparse

import numpy as np
from opensees_pair import material, solve_opensees
from pair_scenes import moderate_scenes
from shortened import either
from side_by_side import OUTPUTS, make_case, relative_errors

from pounding_risk.figures import blank, styles, title, write
from pounding_risk.figures.style import legend_below
from pounding_risk.lab.accuracy_opensees import load

SAMPLES, GAP = 600, 0.02  # of the record; m
STEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5)[: either(8, 2)]  # s


def measure() -> dict[str, np.ndarray]:
    """Relative errors of shape (steps, outputs), by the name of OpenSees' material."""
    ops = load()
    cases = [make_case(scene) for scene in moderate_scenes(SAMPLES, (GAP,))]
    return {
        material(case.scene)[0]: np.array(
            [relative_errors(solve_opensees(ops, case.scene, h), case.truth) for h in STEPS]
        )
        for case in cases
    }


def convergence_figure(measured: dict[str, np.ndarray]) -> object:
    """Errors against the step, a panel for each output."""
    figure, axes = blank(1, len(OUTPUTS), (9.6, 4.2))
    handles = []
    for panel, (axis, output) in enumerate(zip(axes.flat, OUTPUTS, strict=True)):
        for (name, errors), (colour, dash) in zip(measured.items(), styles(len(measured)), strict=True):
            look = {"color": colour, "linestyle": dash, "marker": "o", "markersize": 4.0, "markerfacecolor": "none"}
            handles += axis.loglog(STEPS, errors[:, panel], label=name, **look)
        axis.set(xlabel="step of OpenSees [s]", ylabel=f"error of the {output.replace('_', ' ')}")
    finest = max(float(errors[-1].max()) for errors in measured.values())
    finding = (
        f"Three materials of OpenSees converge to our laws of the same name: within {finest:.0e} at {STEPS[-1]:g} s"
    )
    condition = (
        "periods 0.5 and 1.0 s, gap 20 mm, e = 0.65, 6 s of El Centro; against this package at a tolerance of 1e-12; "
        "JankowskiImpact is jankowski, Hertzdamp hertz_damp, ViscoelasticGap kelvin_voigt"
    )
    title(figure, finding, condition)
    legend_below(figure, handles[: len(measured)], len(measured))
    return figure


def main(arguments: list[str] | None = None) -> int:
    """Measure, print the errors, and write the figure."""
    parser = argparse.ArgumentParser(
        description="Convergence of OpenSees' impact materials to the laws of this package."
    )
    parser.add_argument("--figure", required=True, help="a PNG, SVG or PDF")
    options = parser.parse_args(arguments)
    measured = measure()
    for name, errors in measured.items():
        for h, row in zip(STEPS, errors, strict=True):
            print(f"{name:16s} {h:8g} s  " + "  ".join(f"{error:.1e}" for error in row))
    print(f"written: {write(convergence_figure(measured), options.figure)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
