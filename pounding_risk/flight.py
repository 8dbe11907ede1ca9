import sys

from pounding_risk.core import flight as _now

sys.modules[__name__] = _now
