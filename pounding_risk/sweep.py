import sys

from pounding_risk.core import sweep as _now

sys.modules[__name__] = _now
