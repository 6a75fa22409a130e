"""A docstring's `Example:` is shown as code, as its `Examples:` is."""

from __future__ import annotations

import re
from typing import Any

from griffe import Extension, Object


class OneExample(Extension):
    """Google's style allows both headings; griffe knows the second alone."""

    def on_instance(self, *, obj: Object, **_: Any) -> None:
        """Rename the heading."""
        if obj.docstring is not None:
            text = re.sub(r"^(\s*)Example:$", r"\1Examples:", obj.docstring.value, flags=re.M)
            obj.docstring.value = text.replace("  # doctest: +SKIP", "")
