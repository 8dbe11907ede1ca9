"""Values that many threads ask for: made once, failures told to everyone, the oldest let go."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from pounding_risk._common.once import Shared


def test_whoever_asks_second_waits_for_the_value_of_the_first():
    values, made, go = Shared(), [], Event()

    def make():
        go.wait(5.0)
        made.append(1)
        return "the run"

    with ThreadPoolExecutor(2) as pool:
        both = [pool.submit(values.of, "key", make) for _ in range(2)]
        go.set()
        assert [each.result() for each in both] == ["the run"] * 2
    assert len(made) == 1


def test_a_value_that_cannot_be_made_raises_for_everyone():
    values = Shared()

    def make():
        raise MemoryError("no room")

    for _ in range(2):
        with pytest.raises(MemoryError, match="no room"):
            values.of("key", make)


def test_the_one_asked_for_longest_ago_is_let_go():
    values, made = Shared(2), []

    def value(key):
        return values.of(key, lambda: made.append(key) or key)

    for key in "abaca":  # b is older than a when c comes
        assert value(key) == key
    assert made == ["a", "b", "c"]
    assert value("b") == "b" and made == ["a", "b", "c", "b"]
