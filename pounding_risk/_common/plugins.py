"""Plug-ins: laws, effects, motions, steps, rules, formats of export and commands of other installed packages.

A package names each by an entry point in one of the groups ``pounding_risk.laws``, ``pounding_risk.effects`` and so on
(`GROUPS`), under the name that scenes and commands have for it. Which there are is read from the metadata of the
installed distributions, once in a process, without `importlib.metadata`, whose import alone takes longer than that. A
plug-in is imported when its name is asked for, or when all members of its kind are, never for a list of names, and
never while this package is being imported: its own modules import from here.

One that cannot be loaded is an error where its name is used, and a warning where all members are. Of a name that
this package has as well, this package's member counts, with a warning; a name that two plug-ins have is refused.
"""

from __future__ import annotations

import os
import re
import signal
import sys
import threading
import warnings
from collections.abc import Callable, ItemsView, Iterable, Iterator, Mapping, MutableMapping, ValuesView
from contextlib import contextmanager
from functools import cache, reduce
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError

PREFIX = "pounding_risk."
GROUPS = {
    "laws": "contact law",
    "effects": "effect",
    "motions": "kind of motion",
    "steps": "processing step",
    "rules": "separation rule",
    "writers": "format of export",
    "commands": "command",
}


class PluginWarning(UserWarning):
    """A plug-in is left out, because it cannot be loaded or its name is taken."""


class Plugin(NamedTuple):
    """An entry point of an installed distribution, ``name = value`` in the group ``pounding_risk.group``."""

    group: str
    name: str
    value: str
    distribution: str
    version: str

    @property
    def origin(self) -> str:
        """The distribution and its version."""
        return f"{self.distribution} {self.version}"

    @property
    def words(self) -> str:
        """Distribution, version and entry point."""
        return f'{self.origin} (entry point "{self.name} = {self.value}" in {PREFIX}{self.group})'

    @property
    def module(self) -> str:
        """The module that it is imported from."""
        return self.value.partition("[")[0].partition(":")[0].strip()

    def load(self) -> Any:
        """Import what the entry point names; raises whatever that raises."""
        attributes = self.value.partition("[")[0].partition(":")[2].strip()
        return reduce(getattr, filter(None, attributes.split(".")), import_module(self.module))

    def is_being_imported(self) -> bool:
        """Whether its module is being imported, and has itself asked for a member here: it is not there yet."""
        return getattr(getattr(sys.modules.get(self.module), "__spec__", None), "_initializing", False)


Plugins = Mapping[str, tuple[Plugin, ...]]


@cache
def installed() -> Mapping[str, Plugins]:
    """The plug-ins of all installed distributions: by group, then by name; a name should have one."""
    groups: dict[str, dict[str, tuple[Plugin, ...]]] = {group: {} for group in GROUPS}
    for plugin in _installed():
        if plugin.group in groups:
            groups[plugin.group][plugin.name] = (*groups[plugin.group].get(plugin.name, ()), plugin)
        else:
            hint = nearest(plugin.group, GROUPS)
            tell(f"{plugin.words} is left out: no such group{hint}; groups are {', '.join(GROUPS)}")
    return groups


def plugin_of(group: str, name: str) -> Plugin | None:
    """The plug-in of a name; None where no distribution has one."""
    return next(iter(installed()[group].get(name, ())), None)


def _installed() -> Iterator[Plugin]:
    """Every entry point in a group of ours. Of two distributions of one name the first on the path counts."""
    seen = set()
    for folder in sys.path:
        try:
            names = os.listdir(folder or ".")
        except OSError:  # an archive, or not there
            continue
        for name in sorted(name for name in names if name.endswith((".dist-info", ".egg-info"))):
            if (distribution := name.partition("-")[0].lower()) not in seen:
                seen.add(distribution)
                yield from _plugins_in(Path(folder, name))


def _plugins_in(folder: Path) -> Iterator[Plugin]:
    """The entry points in groups of ours of the distribution with this folder of metadata."""
    text = _read(folder / "entry_points.txt")
    if f"[{PREFIX}" not in text:
        return
    metadata = _read(folder / "METADATA") or _read(folder / "PKG-INFO")
    name, version = (re.search(rf"^{key}: *(\S+)", metadata, re.MULTILINE) for key in ("Name", "Version"))
    group = ""
    for line in map(str.strip, text.splitlines()):
        if line.startswith("["):
            group = line.strip("[] ")
        elif group.startswith(PREFIX) and "=" in line and not line.startswith(("#", ";")):
            key, _, value = line.partition("=")
            facts = name[1] if name else folder.stem, version[1] if version else "of unknown version"
            yield Plugin(group.removeprefix(PREFIX), key.strip(), value.strip(), *facts)


def _read(file: Path) -> str:
    try:
        return file.read_text("utf-8", errors="replace")
    except OSError:
        return ""


class Registry(MutableMapping[str, Any]):
    """The members of one kind by name: of this package, of a user's script, and plug-ins, imported when asked for.

    Parameters
    ----------
    group : str
        One of `GROUPS`; "" for a registry without plug-ins.
    members : mapping, optional
        Members of this package.
    take : callable, optional
        From the name of a plug-in and what it names to the member, for a registry whose members no decorator enters.
        Raises PoundingError for what is none.
    folder : str, optional
        A package of ours whose modules enter members; they are imported when members are asked for.
    arrange : callable, optional
        From the names to the order in which they are listed; by default those of this package come first as they were
        entered, plug-ins then by name.
    """

    def __init__(
        self,
        group: str,
        members: Mapping[str, Any] | None = None,
        take: Callable[[str, Any], Any] | None = None,
        arrange: Callable[[Iterable[str]], list[str]] | None = None,
        folder: str = "",
    ):
        self.group, self.folder = group, folder
        self.members: dict[str, Any] = dict(members or {})
        self._ours, self._take, self._arrange = set(self.members), take, arrange or self._in_order
        self._problems: dict[str, str] = {}  # of plug-ins that were loaded; "" where that went well

    def __getitem__(self, name: str) -> Any:
        self._load_plugin(name)
        return self.members[name]

    def __contains__(self, name: object) -> bool:
        self._load_plugin(name)
        return name in self.members

    def __iter__(self) -> Iterator[str]:
        self._import_folder()
        return iter(self._arrange({**self.members, **dict.fromkeys(self._plugins)}))

    def __len__(self) -> int:
        self._import_folder()
        return len({*self.members, *self._plugins})

    def items(self) -> ItemsView[str, Any]:
        """Names and members, plug-ins imported; those that cannot be loaded are left out with a warning."""
        return self._loaded().items()

    def values(self) -> ValuesView[Any]:
        """The members alone, those of plug-ins among them."""
        return self._loaded().values()

    def __setitem__(self, name: str, member: Any) -> None:
        self.members[name] = member

    def __delitem__(self, name: str) -> None:
        del self.members[name]

    def is_ours(self, name: str) -> bool:
        """Whether this package has a member of this name."""
        return name in self._ours

    def plugin(self, name: str) -> Plugin | None:
        """The plug-in of a name; None where the name is this package's, or unknown."""
        return None if name in self._ours else next(iter(self._plugins.get(name, ())), None)

    def _in_order(self, names: Iterable[str]) -> list[str]:
        last = len(self._plugins)
        place = {name: number for number, name in enumerate(sorted(self._plugins), start=1)}
        return sorted(names, key=lambda name: 0 if name in self._ours else place.get(name, last + 1))

    def reserve(self, names: Iterable[str]) -> None:
        """Keep names of this package that stand in another registry, and mean something in the same key of a scene."""
        self._ours.update(names)

    def enter(self, name: str, member: Any, module: str) -> None:
        """Make known a member that a module defines; raises PoundingError where its name is another one's."""
        if _top(module) == _top(__name__):
            self._ours.add(name)
        elif taken := self.taken(name, module):
            raise PoundingError(f"{GROUPS.get(self.group, 'member')} {name}: {taken}")
        self.members[name] = member

    def taken(self, name: str, module: str) -> str:
        """Why a module outside this package may not define a member of this name; "" where it may."""
        if name in self._ours:
            return f"pounding_risk has a {GROUPS.get(self.group, 'member')} of this name; choose another name"
        other_plugins = [plugin for plugin in self._plugins.get(name, ()) if _top(plugin.module) != _top(module)]
        return f"{other_plugins[0].words} has this name; choose another name, or uninstall it" if other_plugins else ""

    def problem(self, name: str) -> str:
        """Load the plug-in of a name, and say why it cannot be used; "" where it can, or where there is none."""
        plugins = self._plugins.get(name, ())
        if not plugins:
            return ""
        subject = f"{GROUPS[self.group]} {name}: {' and '.join(plugin.words for plugin in plugins)}"
        distributions = [plugin.distribution for plugin in plugins]
        if name in self._ours:
            return (
                f"{subject} ignored, as pounding_risk has this name itself; rename it there, or uninstall "
                f"{' and '.join(distributions)}"
            )
        if name not in self._problems:
            if plugins[0].is_being_imported():
                return ""
            self._problems[name] = (
                self._load(plugins[0])
                if len(plugins) == 1
                else f"{subject} have this name, and which one is meant cannot be known; uninstall "
                f"{' or '.join(distributions)}, or rename it there"
            )
        return self._problems[name]

    @property
    def _plugins(self) -> Plugins:
        return installed().get(self.group, {})

    def _import_folder(self) -> None:
        folder, self.folder = self.folder, ""  # once, and not again while its modules ask for members
        for module in iter_modules(import_module(folder).__path__) if folder else ():
            import_module(f"{folder}.{module.name}")

    def _load_plugin(self, name: Any) -> None:
        self._import_folder()
        if isinstance(name, str) and (problem := self.problem(name)):
            if name not in self._ours:
                raise PoundingError(problem)
            tell(problem)

    def _loaded(self) -> dict[str, Any]:
        problems = {name: self.problem(name) for name in self._plugins}
        for problem in filter(None, problems.values()):
            tell(problem)
        return {name: self.members[name] for name in self if name in self.members}

    def _load(self, plugin: Plugin) -> str:
        """Import a plug-in and enter it among the members; a sentence where that fails, else ""."""
        try:
            with _own_interrupts():
                target = plugin.load()
            if self._take is not None:
                self.members[plugin.name] = self._take(plugin.name, target)
            if plugin.name not in self.members:
                raise PoundingError(
                    f"importing {plugin.module} makes no {GROUPS[self.group]} of this name known; give the entry point "
                    "the name that scenes have for it"
                )
        except (Exception, SystemExit) as error:  # whatever the module of a plug-in may raise
            self.members.pop(plugin.name, None)
            cause = str(error) if isinstance(error, PoundingError) else f"{type(error).__name__}: {error}"
            return (
                f"{GROUPS[self.group]} {plugin.name}: the plug-in {plugin.words} cannot be loaded: {cause}; repair it, "
                f"or uninstall {plugin.distribution}"
            )
        return ""


@contextmanager
def _own_interrupts() -> Iterator[None]:
    """Tell a KeyboardInterrupt that a plug-in raises itself, an error of its own, from one of the user's Ctrl-C."""
    signals: list[int] = []
    handler = signal.getsignal(signal.SIGINT)
    can_listen = threading.current_thread() is threading.main_thread() and callable(handler)

    def note(number: int, frame: Any) -> None:
        signals.append(number)
        handler(number, frame)  # type: ignore[operator,misc] # callable, as checked above

    if can_listen:
        signal.signal(signal.SIGINT, note)
    try:
        yield
    except KeyboardInterrupt as error:
        if signals:
            raise
        raise RuntimeError("it raises KeyboardInterrupt, though nobody pressed Ctrl-C") from error
    finally:
        if can_listen:
            signal.signal(signal.SIGINT, handler)


def _top(module: str) -> str:
    """The package at the top, which a module belongs to."""
    return module.partition(".")[0]


@cache
def tell(sentence: str) -> None:
    """Warn of what is left out, once in a process."""
    warnings.warn(sentence, PluginWarning, stacklevel=2)
