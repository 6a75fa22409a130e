"""The report page of a calibration."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING

from twin.calibration import figures as drawn
from twin.report.html import document, figures, made_with, table

if TYPE_CHECKING:
    from twin.calibration.result import Calibration

HEADERS = ("parameter", "value", "95 % from", "to", "before", "unit", "verdict")


def page(found: Calibration, command: str = "") -> str:
    """The page as HTML."""
    measured = found.foretold + found.fit.residual
    pictures = [
        ("Residuals over time", drawn.residuals(found).svg(),
         "Measured less foretold over the noise's sd; grey is two sd."),
        ("Parity", drawn.parity(found, measured).svg(), "Each channel over its mean."),
    ]  # fmt: skip
    if found.holdout is not None:
        pictures.append(("Slip of the part held back", drawn.ahead(found.holdout).svg(),
                         "Never fitted; the bars are the 95 % band."))  # fmt: skip
    pictures.append(("What is known together", drawn.corner(found.fit),
                     "Ellipses that hold 68 and 95 %; an oblique one: only together."))  # fmt: skip
    parts = [
        f'<p class="soft">{html.escape(found.name)}: {html.escape(found.machine.name)}. '
        f"{html.escape(found.rule)}</p>",
        "<h2>Parameters</h2>" + table(HEADERS, rows(found)),
        _listed("What the log cannot tell apart", found.together),
        _listed("What would settle the rest", settling(found)),
        "<h2>The part held back</h2>" + table(("score", "value"), scores(found)),
        _listed("Notes", (*about(found), *found.notes)),
        figures(pictures),
        made_with(command),
    ]
    return document(f"Calibration of {found.machine.name}", parts)


def rows(found: Calibration) -> list[list[str]]:
    """The table of parameters, as text."""
    return [
        [p.name, f"{p.value:.5g}", f"{p.low:.5g}", f"{p.high:.5g}", f"{p.prior:.5g}", p.unit,
         p.verdict]
        for p in found.parameters
    ]  # fmt: skip


def settling(found: Calibration) -> list[str]:
    """Which measurement would determine a parameter that the log leaves open."""
    return [f"{p.name}: {p.settles}" for p in found.parameters if p.verdict != "identified"]


def scores(found: Calibration) -> list[list[str]]:
    """The scores of the holdout, as text; the gain over the line in words."""
    if found.holdout is None:
        return [["rows", "none"]]
    held = found.holdout.scores
    if held["slip_rms"] is None:
        return [["rows", "foretold without a measured slip"]]
    out = [[name, f"{value:.4f}"] for name, value in held.items() if value is not None]
    low, high = held["gain_low"], held["gain_high"]
    assert low is not None
    assert high is not None
    said = "a tie" if low <= 0.0 <= high else "better" if low > 0.0 else "worse"
    return [*out, ["against the straight line",
                   f"{said}, over blocks of {found.holdout.block_s:.0f} s"]]  # fmt: skip


def about(found: Calibration) -> list[str]:
    """Gears, lag and misfit, in sentences."""
    gears = ", ".join(f"{g.name} (ratio {g.ratio:.4g}, {g.share:.0%})" for g in found.gears)
    out = [f"gears found: {gears or 'none'}"] if found.soil is not None else []
    if math.isfinite(found.lag.lag_s):
        out.append(f"GNSS lags the wheels by {found.lag.lag_s:.2f} s "
                   f"({found.lag.low_s:.2f} to {found.lag.high_s:.2f})")  # fmt: skip
    out.append(f"residuals are {found.fit.misfit:.2f} of the noise; it lasts "
               f"{found.fit.noise.tau_s:.0f} s")  # fmt: skip
    return out


def _listed(title: str, lines: tuple[str, ...] | list[str]) -> str:
    if not lines:
        return ""
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return f"<h2>{html.escape(title)}</h2><ul>{items}</ul>"
