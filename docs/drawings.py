"""Draws the explanations in concepts.md: `python docs/drawings.py` writes docs/pictures/*.svg."""

from __future__ import annotations

from math import cos, radians, sin
from pathlib import Path

HERE = Path(__file__).parent / "pictures"
INK, SOFT, BLUE, RED, SOIL = "#1b1b1b", "#6b6b6b", "#0072B2", "#D55E00", "#cbb79d"
STYLE = "font:14px system-ui,sans-serif"


def main() -> None:
    """Write every drawing."""
    HERE.mkdir(exist_ok=True)
    for name, text in drawings().items():
        (HERE / name).write_text(text, encoding="utf-8")


def drawings() -> dict[str, str]:
    """File name -> SVG text."""
    return {
        "slip.svg": slip(),
        "slip-signs.svg": slip_signs(),
        "sideslip.svg": sideslip(),
        "frames.svg": frames(),
    }


def slip() -> str:
    """A wheel that turns further than it goes."""
    hub_x, hub_y, radius = 190.0, 150.0, 105.0
    ground = hub_y + radius - 6
    parts = [
        f'<rect x="0" y="{ground}" width="640" height="60" fill="{SOIL}"/>',
        f'<circle cx="{hub_x}" cy="{hub_y}" r="{radius}" fill="#333" />',
        f'<circle cx="{hub_x}" cy="{hub_y}" r="62" fill="#e6dfb8"/>',
        f'<circle cx="{hub_x}" cy="{hub_y}" r="6" fill="{INK}"/>',
        _arc(hub_x, hub_y, 82, -150, -60, "#fff"),
        _text(hub_x - 30, hub_y - 22, "ω", INK),
        _line(hub_x, hub_y, hub_x, ground, INK, dash=True),
        _text(hub_x + 8, hub_y + 60, "R", INK),
        _arrow(hub_x, hub_y, hub_x + 150, hub_y, BLUE),
        _text(hub_x + 158, hub_y + 5, "v  speed over ground", BLUE),
        _arrow(hub_x, 24, hub_x + 200, 24, RED),
        _text(hub_x + 208, 29, "ωR  speed of the wheel", RED),
        _line(hub_x + 150, 36, hub_x + 200, 36, INK),
        _text(hub_x + 120, 56, "lost to slip: ωR − v", INK),
        _text(hub_x + 158, 215, "s = (ωR − v) / max(|ωR|, |v|)", INK, size=18),
    ]
    return _svg(640, 300, "Slip of a wheel", parts)


def slip_signs() -> str:
    """The plane of the two speeds: where slip is positive, and where it is beyond 1."""
    x, y, half = 330.0, 265.0, 220.0
    left, right, top, bottom = x - half, x + half, y - half, y + half
    parts = [
        f'<path d="M{left} {bottom} L{left} {top} L{right} {top} z" fill="#fbe9dd"/>',
        f'<path d="M{left} {bottom} L{right} {bottom} L{right} {top} z" fill="#dcebf5"/>',
        f'<path d="M{x} {y} L{left} {y} L{left} {top} L{x} {top} z" fill="{RED}" opacity=".18"/>',
        f'<path d="M{x} {y} L{right} {y} L{right} {bottom} L{x} {bottom} z" fill="{BLUE}" '
        'opacity=".18"/>',
        _line(left, bottom, right, top, INK),
        _line(left, top, right, bottom, SOFT, dash=True),
        _arrow(left, y, right + 22, y, INK),
        _arrow(x, bottom, x, top - 22, INK),
        f'<rect x="{x - 16}" y="{y - 16}" width="32" height="32" fill="#fff" stroke="{INK}"/>',
        _text(x, y + 5, "rest", INK, size=13, anchor="middle"),
        _text(right + 26, y + 5, "v", INK, size=18),
        _text(x + 10, top - 12, "ωR", INK, size=18),
        _text(right + 4, top - 2, "s = 0", INK),
        _text(x - 10, top - 12, "s = 1", RED, anchor="end"),
        _text(left - 6, y + 5, "s = 1", RED, anchor="end"),
        _text(left - 6, top + 5, "s = 2", RED, anchor="end"),
        _text(x, bottom + 20, "s = −1", BLUE, anchor="middle"),
        _text(right + 4, y + 24, "s = −1", BLUE),
        _text(right + 4, bottom + 4, "s = −2", BLUE),
        *_lines(x + 66, top + 46, ("drives forward", "0 &lt; s &lt; 1"), RED),
        *_lines(x + 142, y - 64, ("brakes forward", "−1 &lt; s &lt; 0"), BLUE),
        *_lines(x - 66, y - 182, ("wheels forward,", "slides backward", "1 &lt; s ≤ 2"), RED),
        *_lines(x + 66, y + 146, ("wheels backward,", "slides forward", "−2 ≤ s &lt; −1"), BLUE),
        *_lines(x - 142, y + 48, ("brakes backward", "0 &lt; s &lt; 1"), RED),
        *_lines(x - 66, bottom - 46, ("drives backward", "−1 &lt; s &lt; 0"), BLUE),
    ]
    return _svg(660, 520, "Signs of slip over the speeds of ground and wheel", parts)


def _lines(x: float, y: float, lines: tuple[str, ...], colour: str) -> list[str]:
    return [_text(x, y + 19 * i, line, colour, anchor="middle") for i, line in enumerate(lines)]


def sideslip() -> str:
    """A tractor on a cross-slope that goes where it does not point."""
    x, y, heading, course = 150.0, 215.0, 14.0, 4.0
    place = f'transform="translate({x} {y}) rotate({-heading})"'
    end = (x + 330 * cos(radians(course)), y - 330 * sin(radians(course)))
    nose = (x + 330 * cos(radians(heading)), y - 330 * sin(radians(heading)))
    path = f'<path d="M20 {y + 9} L{x} {y} L{end[0]:.1f} {end[1]:.1f}" fill="none" '
    parts = [
        '<defs><linearGradient id="hill" x1="0" y1="0" x2="0" y2="1">'
        f'<stop offset="0" stop-color="#e6dccb"/><stop offset="1" stop-color="{SOIL}"/>'
        "</linearGradient></defs>",
        '<rect width="640" height="300" fill="url(#hill)"/>',
        _text(16, 26, "uphill", SOFT),
        _text(16, 288, "downhill", SOFT),
        path + f'stroke="{RED}" stroke-width="3"/>',
        f'<g {place} fill="#333">'
        '<rect x="-32" y="-46" width="64" height="20" rx="5"/>'
        '<rect x="-32" y="26" width="64" height="20" rx="5"/>'
        '<rect x="102" y="-40" width="44" height="14" rx="4"/>'
        '<rect x="102" y="26" width="44" height="14" rx="4"/>'
        '<rect x="-22" y="-22" width="172" height="44" rx="8" fill="#b3261e"/>'
        '<circle cx="52" cy="0" r="6" fill="#fff"/></g>',
        _arrow(x + 160, y - 40, nose[0], nose[1], BLUE),
        _text(nose[0] - 40, nose[1] - 14, "heading: where it points", BLUE, anchor="middle"),
        _text(end[0] - 8, end[1] + 26, "course: where it goes", RED, anchor="middle"),
        _arc(x, y, 300, -heading, -course, INK, arrow=False),
        _text(x + 310, y - 44, "β", INK, size=18),
        _text(320, 288, "β = course − heading", INK, size=18),
    ]
    return _svg(640, 300, "Sideslip of a tractor on a cross-slope", parts)


def frames() -> str:
    """World and body axes, seen from above."""
    x, y, heading = 360.0, 170.0, 25.0
    place = f'transform="translate({x} {y}) rotate({-heading})"'
    ahead = (x + 215 * cos(radians(heading)), y - 215 * sin(radians(heading)))
    left = (x - 105 * sin(radians(heading)), y - 105 * cos(radians(heading)))
    parts = [
        _arrow(70, 250, 190, 250, INK),
        _text(196, 255, "east", INK),
        _arrow(70, 250, 70, 130, INK),
        _text(52, 120, "north", INK),
        f'<circle cx="70" cy="250" r="7" fill="#fff" stroke="{INK}"/>'
        f'<circle cx="70" cy="250" r="2.5" fill="{INK}"/>',
        _text(20, 275, "up, towards you", INK),
        f'<g {place} fill="#ddd" stroke="#999">'
        '<rect x="-32" y="-52" width="64" height="22" rx="5"/>'
        '<rect x="-32" y="30" width="64" height="22" rx="5"/>'
        '<rect x="106" y="-46" width="44" height="15" rx="4"/>'
        '<rect x="106" y="31" width="44" height="15" rx="4"/>'
        '<rect x="-22" y="-24" width="176" height="48" rx="8"/></g>',
        _line(x, y, x + 150, y, SOFT, dash=True),
        _arc(x, y, 130, -heading, 0, SOFT, arrow=False),
        _text(x + 138, y - 22, "heading", SOFT),
        _arrow(x, y, ahead[0], ahead[1], BLUE),
        _text(ahead[0] + 6, ahead[1], "x ahead", BLUE),
        _arrow(x, y, left[0], left[1], BLUE),
        _text(left[0] - 20, left[1] - 8, "y left", BLUE),
        f'<circle cx="{x}" cy="{y}" r="5" fill="{BLUE}"/>',
        _text(x - 60, y + 84, "origin: middle of the rear axle", BLUE),
    ]
    return _svg(640, 300, "World axes and body axes", parts)


def _svg(width: int, height: int, title: str, parts: list[str]) -> str:
    heads = "".join(
        f'<marker id="m{c[1:]}" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="6" '
        f'markerHeight="6" orient="auto"><path d="M0 0 L10 5 L0 10 z" fill="{c}"/></marker>'
        for c in (INK, BLUE, RED, SOFT, "#fff")
    )
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="{title}" style="{STYLE}"><title>{title}</title><defs>{heads}</defs>\n'
        f'<rect width="{width}" height="{height}" fill="#fff"/>\n{body}\n</svg>\n'
    )


def _line(x: float, y: float, to_x: float, to_y: float, colour: str, *, dash: bool = False) -> str:
    dashes = ' stroke-dasharray="5 4"' if dash else ""
    where = f'x1="{x:.1f}" y1="{y:.1f}" x2="{to_x:.1f}" y2="{to_y:.1f}"'
    return f'<line {where} stroke="{colour}" stroke-width="2"{dashes}/>'


def _arrow(x: float, y: float, to_x: float, to_y: float, colour: str) -> str:
    line = _line(x, y, to_x, to_y, colour)
    return line.replace('width="2"', f'width="3" marker-end="url(#m{colour[1:]})"')


def _arc(
    x: float, y: float, r: float, start_deg: float, end_deg: float, colour: str, arrow: bool = True
) -> str:
    """An arc about a centre; angles clockwise from the right, as the picture's y goes down."""
    (x0, y0), (x1, y1) = (
        (x + r * cos(radians(a)), y + r * sin(radians(a))) for a in (start_deg, end_deg)
    )
    head = f' marker-end="url(#m{colour[1:]})"' if arrow else ""
    d = f"M{x0:.1f} {y0:.1f} A{r} {r} 0 0 1 {x1:.1f} {y1:.1f}"
    return f'<path d="{d}" fill="none" stroke="{colour}" stroke-width="2.5"{head}/>'


def _text(
    x: float, y: float, text: str, colour: str, *, size: int = 14, anchor: str = "start"
) -> str:
    where = f'x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}"'
    return f'<text {where} fill="{colour}">{text}</text>'


if __name__ == "__main__":
    main()
