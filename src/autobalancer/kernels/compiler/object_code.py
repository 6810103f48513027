"""Compiled kernels as machine code for other programs: no Python and no Numba in it, only ``sin`` and the like of libm.

What Numba keeps of a kernel is its code for LLVM, with calls from Python and from C beside it. Here the kernels of one machine
are put together, everything that leads to Python is cut off, and code is written for any x86-64 with AVX2 and fused
multiplication (x86-64-v3). Nothing is optimized anew, because that could change which products are contracted: the bits are those
of a run in Python.

A kernel has in C the signature ``int name(result *, void **, arguments)`` and returns 0.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import llvmlite.binding as llvm

from autobalancer.kernels.compiler import callbacks

LEVEL = {"cpu": "x86-64-v3", "features": "", "opt": 3}
TRIPLES = {"linux": "x86_64-unknown-linux-gnu", "windows": "x86_64-pc-windows-gnu"}
_PYTHON = re.compile(r"^declare ([^@]*)@((?:Py|NRT|numba_)\w+)\((.*)\)[^()]*$", re.MULTILINE)
_PYTHON_DATA = re.compile(r"^@(PyExc_\w+) = external global .*$", re.MULTILINE)
_SYSTEM = re.compile(r"^target (datalayout|triple) = .*$", re.MULTILINE)


def intermediate_code(kernels: Mapping[str, tuple[Any, Any]]) -> str:
    """Kernels by the names that they get, with the signature of those that declare none, as one module of LLVM.

    Nothing else in it is visible.

    Raises
    ------
    RuntimeError
        If a kernel calls what is not among them, as a law of somebody's own in Python.
    """
    whole = llvm.parse_assembly("")
    for name, (kernel, signature) in kernels.items():
        if not kernel.overloads:
            kernel.compile(signature)
        (result,) = kernel.overloads.values()
        part = llvm.parse_assembly(_without_python(str(result.library._get_module_for_linking())))
        own = part.get_function(result.fndesc.llvm_func_name)
        own.name, own.linkage = name, "external"
        own.visibility = "hidden"  # several machines in one program have kernels of their own
        whole.link_in(part)
    for function in whole.functions:
        if not function.is_declaration and function.name not in kernels:
            function.linkage = "internal"
    for variable in whole.global_variables:
        variable.linkage = "internal"
    passes = llvm.create_new_module_pass_manager()
    for add in ("always_inliner", "simplify_cfg", "global_dead_code_eliminate", "strip_dead_prototype"):
        getattr(passes, f"add_{add}_pass")()
    passes.run(whole, llvm.create_pass_builder(_machine("linux"), llvm.create_pipeline_tuning_options()))
    return str(whole)


@lru_cache(maxsize=2)
def object_code(code: str, system: str) -> bytes:
    """An object file of such a module for ``linux`` or ``windows``."""
    machine = _machine(system)
    module = llvm.parse_assembly(_SYSTEM.sub("", code))
    module.triple, module.data_layout = TRIPLES[system], str(machine.target_data)
    return bytes(machine.emit_object(module))


def function_at(address: int) -> Any:
    """The law that was compiled to be called by this address; None if none was."""
    return next((known.function for known in callbacks._known.values() if known.address == address), None)


def _machine(system: str) -> Any:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple(TRIPLES[system]).create_target_machine(**LEVEL, reloc="pic", codemodel="default")


def _without_python(code: str) -> str:
    """The same where no way leads into what calls Python."""
    code = _PYTHON.sub(r"define internal \1@\2(\3) alwaysinline {\n  unreachable\n}", code)
    return _PYTHON_DATA.sub(r"@\1 = internal global ptr null", code)
