"""Sweeps: a few telling values are tried by the quick tests, all by the complete ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest
from hypothesis import given, settings


def sweep(values: Iterable[Any], *quick: Any) -> list[Any]:
    """Parameters of which all but the quick ones are of the complete tests."""
    values = list(values)
    assert all(each in values for each in quick), quick

    def param(each: Any) -> Any:
        marks = () if each in quick else pytest.mark.complete
        return pytest.param(*(each if type(each) is tuple else (each,)), marks=marks)

    return [param(each) for each in values]


def examples(quick: int, *strategies: Any, **named: Any) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """A property with so many examples; `many` tries it with more."""

    def decorated(check: Callable[..., None]) -> Callable[..., None]:
        property_of = settings(max_examples=quick)(given(*strategies, **named)(check))
        property_of.strategies = strategies, named
        return property_of

    return decorated


def many(property_of: Any, count: int) -> Callable[..., None]:
    """The same property with more examples, of the complete tests."""
    strategies, named = property_of.strategies
    check = property_of.hypothesis.inner_test
    return pytest.mark.complete(settings(max_examples=count)(given(*strategies, **named)(check)))
