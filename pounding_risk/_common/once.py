"""Values that many threads ask for and that are made once."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from threading import Lock
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Shared(Generic[Value]):
    """Values by what they are made of, each made once, by the thread that asks first.

    Of more than ``most`` those asked for longest ago are let go, and made again where they are asked for again.
    """

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._found: OrderedDict[Hashable, Future[Value]] = OrderedDict()
        self._lock = Lock()

    def of(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """The value of this key, made where nobody has asked for it; whoever asks meanwhile waits."""
        with self._lock:
            is_new = key not in self._found
            future = self._found.setdefault(key, Future())
            self._found.move_to_end(key)
            if self._most is not None and len(self._found) > self._most:
                self._found.popitem(last=False)
        if is_new:
            try:
                future.set_result(make())
            except BaseException as error:
                future.set_exception(error)
                raise
        return future.result()
