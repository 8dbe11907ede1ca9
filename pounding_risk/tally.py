import sys

from pounding_risk.core import tally as _now

sys.modules[__name__] = _now
