"""The command `schema`: the JSON schema of scene files, for editors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

from pounding_risk.cli._common.files import announce
from pounding_risk.cli._common.options import out_option

ORDER = 105


def schema(out: Annotated[Path | None, out_option("Write the schema", ".json", absence="printed")] = None) -> None:
    """JSON schema of scene files, for editors."""
    from pounding_risk.scene.sections import schema as made

    text = json.dumps(made(), indent=1, ensure_ascii=False, allow_nan=False)
    if out is None:
        print(text)
    else:
        from pounding_risk._common.written import write_file

        announce(write_file(out, text + "\n"))
