"""Figures from results alone: no solver, no scene. Titles state the finding with numbers taken from the data."""

from __future__ import annotations

from pounding_risk.figures.accuracy import accuracy_figure
from pounding_risk.figures.compare import agreement_figure, reference_figure
from pounding_risk.figures.effects import effects_figure
from pounding_risk.figures.motions import processing_figure, selection_figure, spectra_figure
from pounding_risk.figures.scan import ratio_figure, scan_figure, window_figure
from pounding_risk.figures.simulate import comparison_figure, impact_figure, parting, plateau, simulation_figure
from pounding_risk.figures.style import write

__all__ = [
    "accuracy_figure",
    "agreement_figure",
    "comparison_figure",
    "effects_figure",
    "impact_figure",
    "parting",
    "plateau",
    "processing_figure",
    "ratio_figure",
    "reference_figure",
    "scan_figure",
    "selection_figure",
    "simulation_figure",
    "spectra_figure",
    "window_figure",
    "write",
]
