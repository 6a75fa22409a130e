"""Run the blocks of a page in one process, so that what they import is loaded once.

On stdin, JSON: a list of [kind, text], where a kind is `python`, `bash`, or the name of a file that
is written. The working directory is the page's own. `twin` commands run as the console script does.
"""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

from twin import cli


def run(kind: str, text: str) -> None:
    if kind == "python":
        exec(compile(text, "block", "exec"), {"__name__": "__main__"})
    elif kind == "bash":
        lines = [line for line in text.replace("\\\n", " ").splitlines() if line.strip()]
        if all(line.startswith("twin ") and not re.search(r"[|&;<>$`]", line) for line in lines):
            for line in lines:
                assert cli.main(shlex.split(line, comments=True)[1:]) == 0, line
        else:
            subprocess.run(["bash", "-euo", "pipefail", "-c", text], check=True)
    else:
        Path(kind).write_text(text, encoding="utf-8")
        sys.modules.pop(Path(kind).stem, None)


if __name__ == "__main__":
    sys.path[0] = ""  # as `python -c` has it
    for kind, text in json.load(sys.stdin):
        run(kind, text)
