"""Text that a terminal only shows; this file imports nothing, because every command needs it at once."""

from __future__ import annotations


def escape_unprintable(text: str, kept: str = "\n\t") -> str:
    """Return the text with Python's escapes for unprintable characters, such as ESC, other than those
    ``kept``."""
    return "".join(
        char if char.isprintable() or char in kept else char.encode("unicode_escape").decode()
        for char in text
    )
