"""The command of `report`: the report of a scan, as HTML or PDF."""

from __future__ import annotations

from pounding_risk.questions._declaration import File, Option

ORDER = 150
FUNCTION = "reports"
PASSED = "assessment.assess.assess"
SUBJECT = "results in part"
FILES = {"out": File((".html", ".pdf"), "The report", usual="{}.html")}
OPTIONS = {"also": Option("--with"), "gmfs": None}
