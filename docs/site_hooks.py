"""Hooks of mkdocs: files of the repository outside `docs/` as pages, and a site that stands alone.

A link in `docs/` such as `../VALIDATION.md` leads somewhere in the repository. The site shows such
a file below `repository/`, and links to it are turned there. A folder is linked by its README.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
SHOWN = (
    "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "SECURITY.md", "VALIDATION.md",
    "models/*/README.md", "examples/*",
)  # fmt: skip
"""Files outside `docs/` that the site has."""
UNDER = "repository/"
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
LOADED = re.compile(r"<(?:script|img|iframe|source|video)\b[^>]*\bsrc=[\"']?(?:https?:)?//[^\s>]+")
LINKED = re.compile(r"<link\b[^>]*\bhref=[\"']?(?:https?:)?//[^\s>]+")
IMPORTED = re.compile(r"(?:@import|url\()\s*[\"']?(?:https?:)?//[^\s)]+")


def on_files(files: Files, config: Any) -> Files:
    """Add the repository's files."""
    for pattern in SHOWN:
        for path in sorted(ROOT.glob(pattern)):
            if path.is_file():
                name = UNDER + path.relative_to(ROOT).as_posix()
                files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Turn links that leave `docs/`, and those of the repository's own files into it."""
    source = page.file.src_uri
    folder = Path("docs", source).parent
    if source.startswith(UNDER):
        folder = Path(source.removeprefix(UNDER)).parent

    def turned(match: re.Match[str]) -> str:
        target, _, anchor = match[2].partition("#")
        if not target or ":" in target:
            return match[0]
        path = (ROOT / folder / target).resolve()
        if path.is_dir():
            path /= "README.md"
        if not path.is_relative_to(ROOT):
            return match[0]
        name = path.relative_to(ROOT).as_posix()
        name = name.removeprefix("docs/") if name.startswith("docs/") else UNDER + name
        up = "../" * source.count("/")
        return f"{match[1]}{up}{name}{'#' + anchor if anchor else ''}{match[3]}"

    return LINK.sub(turned, markdown)


def on_post_build(config: Any) -> None:
    """Refuse a page or style that loads anything from elsewhere."""
    loaded = []
    for path in sorted(Path(config["site_dir"]).rglob("*")):
        if path.suffix == ".html":
            text = path.read_text(encoding="utf-8")
            found = LOADED.findall(text) + LINKED.findall(text)
        elif path.suffix == ".css":
            found = IMPORTED.findall(path.read_text(encoding="utf-8"))
        else:
            continue
        loaded += [f"{path.name}: {what}" for what in found]
    if loaded:
        raise PluginError("the site loads from elsewhere: " + "; ".join(loaded))
