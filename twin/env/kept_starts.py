"""Settled starts on disk, beside the compiled code, so that a process need not settle them anew.

A file is named by all that the starts depend on: the sources and libraries that the compiled code
depends on (`twin.compute.compiled.key`), the processor, the machine with its model, the shapes of
the ground, and how the machine is driven. A file that is broken is made anew.
"""

from __future__ import annotations

import hashlib
import inspect
import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from llvmlite import binding

from twin.compute import compiled
from twin.env.fleet import Fleet, Start
from twin.env.grounds import GroundShape
from twin.errors import BadInput
from twin.io.atomic import write_bytes
from twin.machine.build import Machine

DIGEST_BYTES = hashlib.sha256().digest_size


def kept(
    machine: Machine,
    shapes: Sequence[GroundShape],
    seen: bool,
    kind: type[Fleet],
    settle: Callable[[], list[Start]],
) -> list[Start]:
    """The starts of a machine on some shapes of ground: read, or settled and written.

    Args:
        machine: built on level ground.
        shapes: how the field lies under each tractor.
        seen: whether the approach is kept.
        kind: how the machine is driven.
        settle: settles them.
    """
    source = Path(inspect.getfile(kind))
    folder = compiled.folder(Path(__file__))
    if folder is None or compiled.is_edited(source) or compiled.is_edited(Path(__file__)):
        return settle()
    path = folder / f"{_key(machine, shapes, seen, kind, source)}.starts"
    starts = _read(path)
    if starts is None:
        starts = settle()
        with suppress(BadInput):  # a full disk
            content = pickle.dumps(starts)
            write_bytes(path, hashlib.sha256(content).digest() + content)
    return starts


def _key(
    machine: Machine, shapes: Sequence[GroundShape], seen: bool, kind: type[Fleet], source: Path
) -> str:
    """Sixteen hex digits for all that the starts depend on."""
    made_of = pickle.dumps((machine, tuple(shapes), seen, kind.__qualname__))
    processor = binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()
    return compiled.key(source, hashlib.sha256(made_of).hexdigest(), *processor)


def _read(path: Path) -> list[Start] | None:
    """What a file holds; None without a whole one."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, content = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
    if hashlib.sha256(content).digest() != digest:
        return None
    starts: list[Start] = pickle.loads(content)
    return starts
