"""How compiled functions are put together: fragments that only others take in, and entries that Python calls.

Numba makes machine code of every function that a kernel calls, with all that this one calls in turn, and so
optimises the lowest ones again at every level; and a wrapper by which Python could call it. Of a kernel's hundred
functions Python calls one. Here a function that compiled code calls becomes a fragment: LLVM's intermediate code as
numba writes it. The function that Python calls is an entry: it takes in all fragments below it, each once, is optimised
as one piece and becomes machine code. Compiling takes half as long.
"""

from __future__ import annotations

import gc
from collections.abc import Iterable
from contextlib import contextmanager

from llvmlite import binding as llvm  # type: ignore[import-untyped]
from numba import _dynfunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.entrypoints import init_all
from numba.core.environment import lookup_environment

ENVIRONMENT = "_ZN08NumbaEnv"  # begins the name of a function's constants that are Python objects


class Fragment(JITCodeLibrary):
    """The intermediate code of one function, for others to take in."""

    always_inline = False
    _linking_libraries: list[JITCodeLibrary]

    def _optimize_functions(self, ll_module):
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self):
        """End the fragment: set the linkage with which callers take its functions in, each once."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"
                if self.always_inline:
                    function.add_function_attribute("alwaysinline")
        for variable in self._final_module.global_variables:
            if variable.name.startswith(ENVIRONMENT):
                variable.linkage = "linkonce_odr"  # gone where nothing uses it
        self._finalized = True

    def own_code(self):
        """The intermediate code of the function, without that of the functions that it calls."""
        self._ensure_finalized()
        return self._final_module

    def _get_module_for_linking(self):
        # For a function that is compiled in numba's own way, as a user's: with all that this one calls.
        module = self.own_code().clone()
        for library in gathered(self._linking_libraries):
            module.link_in(code_of(library), preserve=True)
        return module

    def get_pointer_to_function(self, name):
        """None: there is no machine code."""
        return 0


class Inlined(Fragment):
    """A `Fragment` that is always taken into the body of its caller."""

    always_inline = True


class Entry(JITCodeLibrary):
    """Machine code of a function, with all fragments below it."""

    _linking_libraries: list[JITCodeLibrary]

    def finalize(self):
        """Take in the fragments, optimise the whole and make it machine code.

        Nobody else calls what is taken in: LLVM puts a fragment with one call into its caller, however large it is.
        """
        libraries = gathered(self._linking_libraries)
        self._linking_libraries = []
        for library in libraries:
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(code_of(library), preserve=True)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
                function.linkage = llvm.Linkage.internal
        super().finalize()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name)
            if environment is not None:
                self._codegen.set_env(variable.name, environment)

    def serialize_using_object_code(self):
        """What the cache keeps: the machine code, and which symbols it defines.

        Numba keeps the intermediate code as well, for others to take in, and reads it at each start. Nothing takes in
        an entry: compiled code that calls the function has its fragment.
        """
        self._ensure_finalized()
        return self.name, "object", (self._get_compiled_object(), _symbols_of(self._final_module).as_bitcode())


def _symbols_of(module) -> llvm.ModuleRef:
    """A module with empty functions of the names that others can call in this one, and its constants from Python."""
    hidden = (llvm.Linkage.internal, llvm.Linkage.private)
    functions = (one.name for one in module.functions if not one.is_declaration and one.linkage not in hidden)
    constants = (one.name for one in module.global_variables if one.name.startswith(ENVIRONMENT))
    lines = [f'define void @"{name}"() {{ ret void }}' for name in functions]
    return llvm.parse_assembly("\n".join([*lines, *(f'@"{name}" = global i8 0' for name in constants)]))


def gathered(libraries: Iterable[JITCodeLibrary]) -> list[JITCodeLibrary]:
    """These libraries and the fragments below them, each once, fragments first.

    Of numba's own library for arrays LLVM takes in what is called by then. What a fragment calls that is taken in later
    would be missing from a cached kernel, which is found out where it is loaded by a call of address 0.
    """
    visited: dict[JITCodeLibrary, None] = {}
    pending = list(libraries)[::-1]
    while pending:
        library = pending.pop()
        if library not in visited:
            visited[library] = None
            if isinstance(library, Fragment):
                pending += library._linking_libraries[::-1]
    return sorted(visited, key=lambda library: not isinstance(library, Fragment))


def code_of(library: JITCodeLibrary):
    """The code of a library, of a fragment without what it calls."""
    return library.own_code() if isinstance(library, Fragment) else library._get_module_for_linking()


class FragmentFlags(Flags):
    """Flags of a fragment, which numba looks up with every call that it types: of equal hash, and compared as set."""

    __slots__ = ()

    def __hash__(self):
        return hash(FragmentFlags)

    def __eq__(self, other):
        return isinstance(other, FragmentFlags) and self._values == other._values


class Garbage:
    """Cyclic garbage while an entry is compiled: what numba leaves of each fragment, freed every few fragments.

    Python would look for it among all objects that there are, in a seventh of the time of compiling; or leave it to the
    end, when it is a third of the memory. Objects that were there before, or stayed, are out of the search: frozen.
    """

    EVERY = 5  # fragments
    OF_PYTHON = 1000  # objects; at its start 3.12 freezes some 400 of its own, other versions none

    def __init__(self) -> None:
        self.is_ours, self.fragments = False, 0

    @contextmanager
    def freed(self):
        """Within this `one_more` frees the garbage; where objects are frozen by others, nothing is changed."""
        if gc.get_freeze_count() > self.OF_PYTHON or not gc.isenabled():
            yield
            return
        gc.disable()
        gc.freeze()
        self.is_ours = True
        try:
            yield
        finally:
            self.is_ours = False
            gc.unfreeze()
            gc.enable()

    def one_more(self) -> None:
        """A fragment has been compiled."""
        self.fragments += 1
        if self.is_ours and self.fragments % self.EVERY == 0:
            gc.collect()
            gc.freeze()


GARBAGE = Garbage()


class FragmentCompiler(Compiler):
    """Numba's compiler, up to the intermediate code."""

    library_class = Fragment

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, locals):
        if library is None and args is not None:
            library = self.library_class(targetctx.codegen(), "fragment")
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        super().__init__(typingctx, targetctx, library, args, return_type, FragmentFlags(flags), locals)

    def _compile_core(self):
        compiled = super()._compile_core()
        described = compiled.fndesc
        # What numba knows the function by; nobody calls it.
        key = _dynfunc.make_function(
            described.lookup_module(), described.qualname, "", 0, compiled.environment, (compiled.library,)
        )
        compiled.target_context.insert_user_function(key, described, [compiled.library])
        GARBAGE.one_more()
        # Numba's own form of the function, and the types in it, which it leaves out of its cache as well.
        described.typemap = described.calltypes = None
        return compiled._replace(entry_point=key, metadata={}, type_annotation=None)


class InlinedCompiler(FragmentCompiler):
    """As `FragmentCompiler`, for what is always taken into the body of its caller."""

    library_class = Inlined


class EntryCompiler(_FunctionCompiler):
    """Makes machine code for Python of a function that ``fragments``, a dispatcher, has compiled to a fragment."""

    def __init__(self, py_func, targetdescr, targetoptions, locals, pipeline_class, fragments=None):
        super().__init__(py_func, targetdescr, targetoptions, locals, pipeline_class)
        self.fragments = fragments

    def _compile_core(self, args, return_type):
        init_all()  # numba's extensions, which a user's law may use
        with GARBAGE.freed():
            return self._compiled(args)

    def _compiled(self, args):
        self.fragments.compile(args)
        compiled = self.fragments.overloads[tuple(args)]
        context = compiled.target_context
        library = entry_library(context, compiled)
        with context.push_code_library(library):
            context.create_cpython_wrapper(
                library, compiled.fndesc, compiled.environment, compiled.call_helper, release_gil=True
            )
        called = context.get_executable(library, compiled.fndesc, compiled.environment)
        return compiled._replace(library=library, entry_point=called, metadata={}, type_annotation=None)


def entry_library(context, compiled) -> Entry:
    """An `Entry` without wrapper of what has been compiled to a fragment."""
    library = Entry(context.codegen(), compiled.fndesc.qualname)
    library.enable_object_caching()
    library.add_linking_library(compiled.library)
    return library
