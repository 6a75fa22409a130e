"""What a calibration found before it was killed."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twin.io.atomic import write_text

Array = NDArray[np.float64]


@dataclass
class Memory:
    """What was found before a calibration was killed, kept in a file until it is done."""

    path: Path | None
    key: str
    kept: dict[str, list[float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.path is not None and self.path.is_file():
            try:
                raw = json.loads(self.path.read_text(encoding="utf-8"))
                self.kept = raw["kept"] if raw["key"] == self.key else {}
            except (ValueError, KeyError, TypeError):
                self.kept = {}

    def __call__(self, name: str, find: Callable[[], Array]) -> Array:
        """What is kept under a name, or what is found and then kept."""
        if name not in self.kept:
            self.kept[name] = find().tolist()
            if self.path is not None:
                write_text(self.path, json.dumps({"key": self.key, "kept": self.kept}))
        return np.array(self.kept[name])

    def forget(self) -> None:
        """Remove the file."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)
