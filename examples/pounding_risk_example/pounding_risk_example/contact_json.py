"""A format of `pounding-risk export --to contact_json`: the share of cases with contact at each gap."""

import json

from pounding_risk.reports.exports import Written, write_file

WORDS = "share of cases with contact at each gap"
ENDINGS = (".json",)
SOURCE = "results"
TAKES = ()


def write(results, target, asked):
    """Write one file, from the gap [m] to the share of cases with contact."""
    touched = results["impact_count"] > 0
    share = touched.mean([dim for dim in touched.dims if dim != "gap"])
    table = {f"{float(gap):g}": round(float(value), 4) for gap, value in zip(share["gap"], share, strict=True)}
    text = json.dumps({"title": results.attrs["title"], "contact": table}, indent=2, ensure_ascii=False)
    return Written((write_file(target, f"{text}\n"),), ("records count once each, whatever recording they are of",))
