"""The command of `draw`: pictures of a row from its dataset."""

from __future__ import annotations

from pounding_risk.questions._declaration import File, Option

ORDER = 200
FUNCTION = "reports.drawings"
SUBJECT = "results of rows"
PICTURES = (".png", ".svg", ".pdf")
FILES = {
    "elevation": File(PICTURES, "The row in elevation"),
    "plan": File(PICTURES, "The street in plan"),
    "profiles": File(PICTURES, "Storeys"),
    "animation": File((".html",), "One run with its histories, moving"),
}
OPTIONS = {"figure": Option(kind=list[str], metavar="NAME=FILE")}
