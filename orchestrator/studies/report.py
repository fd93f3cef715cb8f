"""Words of tables: in Markdown for the manual, and shares in per cent."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def markdown_table(head: Sequence[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown for the manual."""
    cells = (" | ".join(cell.replace("|", "\\|") for cell in row) for row in (head, *rows))
    first, *others = (f"| {line} |" for line in cells)
    return "\n".join([first, "|" + "---|" * len(head), *others]) + "\n"


def percent(share: float | None) -> str:
    """Return a share in per cent with two digits, or an empty text for no share."""
    if share is None:
        return ""
    return f"{100 * share:.2g} %" if abs(share) < 0.1 else f"{100 * share:.0f} %"
