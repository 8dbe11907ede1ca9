import sys

from pounding_risk import collision as _now

sys.modules[__name__] = _now
