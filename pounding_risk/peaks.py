import sys

from pounding_risk.core import peaks as _now

sys.modules[__name__] = _now
