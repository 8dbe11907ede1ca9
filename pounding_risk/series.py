import sys

from pounding_risk.core import series as _now

sys.modules[__name__] = _now
