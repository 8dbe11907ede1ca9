"""The numbers of the shipped scenes, variable by variable, are those of the program before its modules were moved."""

import json

import pytest
from shipped_numbers import KEPT, arithmetic, datasets, digests


@pytest.fixture(scope="module")
def kept():
    return json.loads(KEPT.read_text(encoding="utf-8"))


def test_every_number_is_the_same(kept):
    """Bit by bit where the libraries and the processor are those of the kept digests.

    Elsewhere the last digits of a library's functions may differ, and with them the count of touches of a long
    run: there the mean of each variable is compared, to 2 % (a touch more or less in a few dozen).
    """
    same_arithmetic = kept["arithmetic"] == arithmetic()
    seen = {}
    for name, dataset in datasets():
        seen[name] = digests(dataset)
        before = kept["datasets"][name]
        assert sorted(seen[name]) == sorted(before), name
        if same_arithmetic:
            changed = [variable for variable in before if before[variable][0] != seen[name][variable][0]]
            assert changed == [], name
        for variable, (_, mean) in before.items():
            if mean is not None:
                assert seen[name][variable][1] == pytest.approx(mean, rel=0.02, abs=1e-9), f"{name}: {variable}"
    assert sorted(seen) == sorted(kept["datasets"])
