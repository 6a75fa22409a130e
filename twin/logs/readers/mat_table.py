"""MATLAB files: every numeric vector as a signal, by the path of its structs.

Up to version 7.2 by scipy, 7.3 (HDF5) by h5py. A struct's field is called `gps.speed`, a column of
a matrix `gps.position(:,2)`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from twin.errors import BadInput
from twin.io.plain import Plain
from twin.logs.cells import Text
from twin.logs.reader import Reader
from twin.logs.readers.reading import Reading
from twin.logs.signals import Found, Signal
from twin.plugins.extras import needed, refused_if_damaged
from twin.streams import Array

MOST_COLUMNS = 64
_HDF = b"\x89HDF\r\n"


class Mat(Reader):
    """A .mat file."""

    name = "MATLAB"

    def fits(self, path: Path, head: bytes) -> bool:
        """By its suffix or how it begins."""
        known = path.suffix.lower() == ".mat" or head.startswith(b"MATLAB 5.0 MAT-file")
        return not path.is_dir() and known

    def found(self, path: Path, reading: Reading) -> Found:
        """Its vectors. Raises BadInput."""
        with path.open("rb") as file:
            head = file.read(1024)
        hdf = _HDF in head[:16] or head[512:].startswith(_HDF) or b"MATLAB 7.3" in head[:128]
        with refused_if_damaged("a .mat file"):
            vectors = dict(_of_hdf(path) if hdf else _of_mat(path))
        if not vectors:
            raise BadInput("a .mat file without a numeric vector; tables and objects of MATLAB"
                           " become structs by table2struct(T, 'ToScalar', true)")  # fmt: skip
        return Found(signals={name: Signal(values) for name, values in vectors.items()})


def _of_mat(path: Path) -> Iterator[tuple[str, Array | Text]]:
    from scipy.io import loadmat

    content = loadmat(path, squeeze_me=True, struct_as_record=False, chars_as_strings=True)
    for name, value in content.items():
        if not name.startswith("__"):
            yield from _flat(name, value)


def _flat(name: str, value: Plain) -> Iterator[tuple[str, Array | Text]]:
    if hasattr(value, "_fieldnames"):
        for field in value._fieldnames:
            yield from _flat(f"{name}.{field}", getattr(value, field))
    elif isinstance(value, np.ndarray):
        yield from _vectors(name, value)


def _of_hdf(path: Path) -> Iterator[tuple[str, Array | Text]]:
    h5py = needed("h5py", "mat", ".mat files of version 7.3", "h5py")
    with h5py.File(path, "r") as file:
        found: dict[str, Array] = {}

        def visit(name: str, item: Plain) -> None:
            if isinstance(item, h5py.Dataset) and not name.startswith("#"):
                found[name.replace("/", ".")] = np.asarray(item).T  # MATLAB's order

        file.visititems(visit)
    for name, value in found.items():
        yield from _vectors(name, np.squeeze(value))


def _vectors(name: str, value: Array) -> Iterator[tuple[str, Array | Text]]:
    if value.dtype.kind in "US" and value.ndim == 1:
        yield name, Text.of([str(v) for v in value])
    elif value.dtype.kind in "iufb" and value.ndim == 1 and len(value) > 1:
        yield name, value
    elif value.dtype.kind in "iufb" and value.ndim == 2:
        tall = value if value.shape[0] >= value.shape[1] else value.T
        if tall.shape[1] <= MOST_COLUMNS:
            for column in range(tall.shape[1]):
                yield f"{name}(:,{column + 1})", np.ascontiguousarray(tall[:, column])
