"""Settled starts on disk, beside the compiled code, so that a process need not settle them anew.

A file is named by all that the starts depend on: the sources and libraries that the compiled code
depends on (`twin.compute.compiled.key`), the processor, the machine with its model, the shapes of
the ground, and how the machine is driven. A file that is broken is made anew.
"""

from __future__ import annotations

import hashlib
import inspect
import io
import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite import binding
from numpy.typing import NDArray

from twin.compute import compiled
from twin.env.fleet import Fleet, GroundFrame, Start
from twin.env.grounds import GroundShape
from twin.errors import BadInput
from twin.io.atomic import write_bytes
from twin.machine.build import Machine
from twin.trajectory.trajectory import Trajectory

DIGEST_BYTES = hashlib.sha256().digest_size
COLUMN = "column."
"""What the name of a column of the approach begins with in a file."""


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
    content = _read(path)
    if content is not None:
        return _unpacked(content, machine, shapes)
    starts = settle()
    with suppress(BadInput):  # a full disk
        content = _packed(starts)
        write_bytes(path, hashlib.sha256(content).digest() + content)
    return starts


def _key(
    machine: Machine, shapes: Sequence[GroundShape], seen: bool, kind: type[Fleet], source: Path
) -> str:
    """Sixteen hex digits for all that the starts depend on."""
    made_of = pickle.dumps((machine, tuple(shapes), seen, kind.__qualname__))
    processor = binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()
    return compiled.key(source, hashlib.sha256(made_of).hexdigest(), *processor)


def _read(path: Path) -> bytes | None:
    """What a file holds behind its checksum; None without a whole one."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, content = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
    return content if hashlib.sha256(content).digest() == digest else None


def _packed(starts: Sequence[Start]) -> bytes:
    """Starts as the bytes of an npz file: arrays alone, nothing that is code."""
    held: dict[str, NDArray[Any]] = {
        name: np.array([getattr(start, name) for start in starts])
        for name in ("state", "along_m", "driver", "pedal", "action")
    }
    approaches = [start.approach for start in starts if start.approach is not None]
    if approaches:
        held["epoch_ns"] = np.stack([each.epoch_ns for each in approaches])
        for name in approaches[0].columns:
            held[COLUMN + name] = np.stack([each.columns[name] for each in approaches])
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **held)
    return buffer.getvalue()


def _unpacked(content: bytes, machine: Machine, shapes: Sequence[GroundShape]) -> list[Start]:
    """The starts that `_packed` made, one for each shape."""
    with np.load(io.BytesIO(content), allow_pickle=False) as kept_arrays:
        held = {name: kept_arrays[name] for name in kept_arrays.files}
    columns = {n.removeprefix(COLUMN): c for n, c in held.items() if n.startswith(COLUMN)}
    starts = []
    for i, shape in enumerate(shapes):
        approach = None
        if columns:
            own = {name: column[i] for name, column in columns.items()}
            approach = Trajectory(held["epoch_ns"][i], own)
        starts.append(
            Start(
                state=held["state"][i],
                frame=GroundFrame.of(shape, machine.scenario.course),
                approach=approach,
                along_m=float(held["along_m"][i]),
                driver=held["driver"][i],
                pedal=held["pedal"][i],
                action=tuple(held["action"][i].tolist()),
            )
        )
    return starts
