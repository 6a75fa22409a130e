"""A compiled function that costs little to compile where only compiled functions call it.

numba makes everything of a function that could be needed: what Python calls it by, machine code
of its own, and a place in its cache, once for each function. Nearly all functions of a law or a
filter are called by compiled ones alone. Here such a function becomes code that is linked into its
callers and optimised there. What Python itself calls is compiled as numba does it.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, TypeAlias

import numba.core.types
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags, compile_extra
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature

from twin.compute.call_types import remembering

Untyped: TypeAlias = Any
"""What is numba's own, which has no types."""


class _Library(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """A library that leaves alone what is only declared in it, which has nothing to optimise."""

    def _optimize_functions(self, ll_module: Untyped) -> None:
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)


class _Linked(_Library):
    """A library that becomes part of others: no machine code, and optimised there."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


class _Flags(Flags):  # type: ignore[misc]
    """Options that are compared by what is set: numba does so for every operation of a function."""

    _HASH = hash(tuple(sorted(Flags.options)))

    def __hash__(self) -> int:
        return self._HASH

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Flags) and self._values == other._values


_FOR_OTHERS = frozenset(
    {
        untyped_passes.WithLifting,
        untyped_passes.InlineClosureLikes,
        untyped_passes.MakeFunctionToJitFunction,
        untyped_passes.InlineInlinables,
        untyped_passes.DeadBranchPrune,
        untyped_passes.FindLiterallyCalls,
        untyped_passes.LiteralUnroll,
        untyped_passes.LiteralPropagationSubPipelinePass,
        typed_passes.InlineOverloads,
        typed_passes.DumpParforDiagnostics,
    }
)
"""Passes over a function for what no kernel has: closures, with blocks, branches on types."""


class _Passes(Compiler):  # type: ignore[misc]
    """numba's passes over a function without those for others."""

    def define_pipelines(self) -> list[PassManager]:
        (whole,) = super().define_pipelines()
        kept = PassManager(whole.pipeline_name)
        kept.passes.extend(each for each in whole.passes if each[0] not in _FOR_OTHERS)
        kept.finalize()
        return [kept]


class _Compiler(_FunctionCompiler):  # type: ignore[misc]
    """numba's compiler of a function, into a library of ours."""

    library: type[_Library] = _Library

    def _compile_core(self, args: Untyped, return_type: Untyped) -> Untyped:
        flags = _Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        target = self.targetdescr.target_context
        library = self.library(target.codegen(), self.py_func.__qualname__)
        library.enable_object_caching()
        result = compile_extra(
            remembering(self.targetdescr.typing_context), target, self.py_func, args, return_type,
            self._customize_flags(flags), self.locals, library, _Passes,
        )  # fmt: skip
        if not flags.no_compile:  # of what is linked in, too
            for environment in result._find_referenced_environments():
                library.codegen.set_env(environment.env_name, environment)
        return result


class _Inner(_Compiler):
    library = _Linked

    def _customize_flags(self, flags: Untyped) -> Untyped:
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        return flags


class _Callee(CPUDispatcher):  # type: ignore[misc]
    """A function as compiled ones call it; Python cannot."""

    def __init__(self, *args: Untyped, **options: Untyped) -> None:
        super().__init__(*args, **options)
        old: Untyped = self._compiler
        self._compiler: Untyped = _Inner(
            old.py_func, old.targetdescr, old.targetoptions, old.locals, old.pipeline_class
        )

    def compile(self, sig: Untyped) -> Untyped:
        """The key by which callers find the code for these types."""
        with global_compiler_lock:
            args, return_type = normalize_signature(sig)
            known = self.overloads.get(tuple(args))
            if known is None:
                with self._compiling_counter:
                    known = self._compiler.compile(args, return_type)
                known = known._replace(entry_point=object())
                self.targetctx.insert_user_function(
                    known.entry_point, known.fndesc, [known.library]
                )
                self.overloads[tuple(args)] = known
            return known.entry_point


def _general(kind: Untyped) -> Untyped:
    """The type that a function is compiled for: once for all integers, also for constants."""
    types: Untyped = numba.core.types
    kind = types.unliteral(kind)
    if isinstance(kind, types.IntEnumMember):
        kind = kind.dtype
    small = isinstance(kind, types.Integer) and kind.signed and kind.bitwidth < types.intp.bitwidth
    return types.intp if small else kind


@contextmanager
def without_collection() -> Iterator[None]:
    """Leave garbage for later: compiling makes many objects, and a sixth of it is their search."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A function that Python calls as numba's own, and compiled functions as a part of theirs."""

    def __init__(self, *args: Untyped, **options: Untyped) -> None:
        super().__init__(*args, **options)
        old: Untyped = self._compiler
        self._compiler: Untyped = _Compiler(
            old.py_func, old.targetdescr, old.targetoptions, old.locals, old.pipeline_class
        )

    def compile(self, sig: Untyped) -> Untyped:
        """The function that Python calls for these types."""
        with without_collection():
            return super().compile(sig)

    @cached_property
    def callee(self) -> _Callee:
        """The function as compiled ones call it."""
        return _Callee(self.py_func, targetoptions=self.targetoptions)

    def get_call_template(self, args: Untyped, kws: Untyped) -> Untyped:
        """How a compiled function calls this one; it is compiled first."""
        named = {name: _general(kind) for name, kind in kws.items()}
        return self.callee.get_call_template([_general(kind) for kind in args], named)

    def get_overload(self, sig: Untyped) -> Untyped:
        """The key of the code for some types."""
        return self.callee.get_overload(sig)
