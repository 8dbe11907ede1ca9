"""Effect of baseline corrections on a raw record: ``python benchmarks/baseline.py``, with ``--figure FILE`` a figure.

CCC-HN1, Ridgecrest 2019 M 7.1, 150 s as recorded, treated in eight ways. Peaks of acceleration, velocity and
displacement, the displacement at the end, and spectral acceleration, which hardly sees any of it.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np

from pounding_risk.figures.style import STYLES, blank, title, write
from pounding_risk.motions.intensity import response_spectra
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.units import STANDARD_GRAVITY

RECORD = "CCC-HN1"
PERIODS = (0.5, 1.0, 2.0, 6.0)  # s
MEAN, TAPER, BAND, POLYNOMIAL = ({"step": name} for name in ("mean", "taper", "bandpass", "baseline"))
GMPROCESS = {"step": "bandpass", "low": "0.0618 Hz", "high": "37.5 Hz"}  # its corners for this recording
AS_IT_IS, LEVELLED = "as distributed", "mean before the earthquake subtracted"
CHAIN, SHIFTED = "default chain", "bilinear: an offset subtracted"
TREATMENTS: dict[str, Any] = {
    AS_IT_IS: "none",
    LEVELLED: [MEAN],
    "straight line in acceleration": [{"step": "trend"}],
    "polynomial in displacement, no filter": [MEAN, TAPER, POLYNOMIAL],
    SHIFTED: [MEAN, {"step": "baseline", "scheme": "bilinear"}],
    "band-pass with gmprocess' corners, polynomial": [MEAN, TAPER, GMPROCESS, POLYNOMIAL],
    CHAIN: "auto",
    "band-pass, pads kept": [MEAN, TAPER, {"step": "bandpass", "pads": "kept"}],
}


def treated() -> dict[str, Motion]:
    """The record after each treatment."""
    return {name: read_motion(RECORD, processing=steps) for name, steps in TREATMENTS.items()}


def peaks(motion: Motion) -> tuple[float, float, float, float]:
    """PGA [g], PGV [cm/s], PGD [cm], displacement at the end [cm]."""
    velocity, displacement = motion.velocity_displacement()
    pgv, pgd = (100.0 * float(np.abs(trace).max()) for trace in (velocity, displacement))
    return motion.pga / STANDARD_GRAVITY, pgv, pgd, 100.0 * float(displacement[-1])


def draw(motions: dict[str, Motion], path: str) -> None:
    """Acceleration, velocity, and displacement before and after, over the same time."""
    figure, axes = blank(4, 1, size=(8.0, 9.0), sharex=True)
    acceleration, velocity, before, after = axes[:, 0]
    colours = dict(zip((CHAIN, SHIFTED, AS_IT_IS, LEVELLED), STYLES, strict=False))
    for name, (colour, dash) in colours.items():
        motion = motions[name]
        first, second = motion.velocity_displacement()
        drifts = name in (AS_IT_IS, LEVELLED)
        velocity.plot(motion.times, first, color=colour, linestyle=dash, linewidth=1.1, label=name)
        axis, scale = (before, 1.0) if drifts else (after, 100.0)
        axis.plot(motion.times, scale * second, color=colour, linestyle=dash, linewidth=1.4, label=name)
    corrected = motions[CHAIN]
    acceleration.plot(corrected.times, corrected.acceleration / STANDARD_GRAVITY, color=STYLES[0][0], linewidth=0.6)
    acceleration.text(0.99, 0.9, "alike after any treatment", transform=acceleration.transAxes, ha="right", va="top")
    for axis, words in (
        (acceleration, "acceleration [g]"),
        (velocity, "velocity [m/s]"),
        (before, "displacement [m]\nuncorrected"),
        (after, "displacement [cm]\ncorrected"),
    ):
        axis.set_ylabel(words)
    for axis in (velocity, before, after):
        axis.legend(fontsize=8, loc="best", framealpha=0.9)
    after.set_xlabel("time [s]")
    after.set_xlim(0.0, corrected.duration)
    lost, kept = abs(peaks(motions[LEVELLED])[3]) / 100.0, peaks(motions[SHIFTED])[3]
    finding = f"A baseline that shifts by 3 mm/s² in the shaking, 0.07 % of PGA, drifts {lost:.0f} m"
    condition = f"The default chain takes every slow part away; the bilinear scheme leaves {kept:.0f} cm standing"
    title(
        figure, finding, condition, f"{RECORD}, Ridgecrest 2019 M 7.1, raw; no survey at the site confirms the latter"
    )
    write(figure, path)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--figure", metavar="FILE", help="PNG, SVG or PDF to write")
    asked = parser.parse_args(arguments)
    motions = treated()
    print("| treatment | PGA [g] | PGV [cm/s] | PGD [cm] | at the end [cm] | Sa [g] at " + ", ".join(
        f"{period:g}" for period in PERIODS) + " s |")  # fmt: skip
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for name, motion in motions.items():
        pga, pgv, pgd, end = peaks(motion)
        spectrum = response_spectra(motion.acceleration, motion.dt, PERIODS).pseudo_acceleration / STANDARD_GRAVITY
        told = ", ".join(f"{value:.4f}" for value in spectrum)
        print(f"| {name} | {pga:.4f} | {pgv:.1f} | {pgd:.1f} | {end:.1f} | {told} |")
    if asked.figure:
        draw(motions, asked.figure)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
