"""The command of `convert`: a dataset in the other file format."""

from __future__ import annotations

from pounding_risk.questions._declaration import Option

ORDER = 180
FUNCTION = "studies.convert"
OPTIONS = {"source": Option(metavar="SOURCE", is_argument=True), "target": Option(metavar="TARGET", is_argument=True)}
