"""matplotlib is as it was after its axes are imported without their tables."""

import subprocess
import sys


def test_the_tables_of_properties_are_made_again_afterwards():
    code = (
        "import twin.report.bare_matplotlib, matplotlib.artist as a, matplotlib.lines as l; "
        "assert 'linewidth' in a.kwdoc(l.Line2D)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
