"""Where the MJCF models are: inside the installed package, or beside it in a checkout."""

from __future__ import annotations

from pathlib import Path

from twin.errors import BadInput


def model_path(name: str) -> Path:
    """Path of a model's MJCF, `models/<name>/<name>.xml`. Raises BadInput if it is not there."""
    package = Path(__file__).parent.parent
    for folder in (package / "_models", package.parent / "models"):
        path = folder / name / f"{name}.xml"
        if path.is_file():
            return path
    raise BadInput(f"model '{name}' is neither in {package / '_models'} nor in models/ beside it")
