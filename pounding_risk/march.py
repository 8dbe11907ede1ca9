import sys

from pounding_risk import pair as _now

sys.modules[__name__] = _now
