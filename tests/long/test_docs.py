"""Every page of docs/ from its first block to its last, commands too."""

from pathlib import Path

import pytest

from tests.docs.test_blocks import RUN, name, runs


@pytest.mark.parametrize("page", RUN, ids=name)
def test_every_block_runs(page: Path, tmp_path: Path) -> None:
    runs(page, tmp_path, "python", "bash")
