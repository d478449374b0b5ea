"""For notebooks: tables of facts, and the pages that runs and sweeps write."""

from __future__ import annotations

import html
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._native import Experiment


def facts(title: str, values: Mapping[str, object]) -> str:
    """A table of names and values under a title."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{html.escape(name)}</th><td style='text-align:left'>{html.escape(str(value))}</td></tr>"
        for name, value in values.items()
    )
    return f"<table><caption style='text-align:left'><b>{html.escape(title)}</b></caption>{rows}</table>"


def framed(page: Path) -> str:
    """A page in a frame, apart from the notebook; empty if there is none."""
    try:
        return frame(page.name, page.read_text(encoding="utf-8"))
    except OSError:
        return ""


def frame(title: str, page: str) -> str:
    """A page's text in a frame."""
    return (
        f"<iframe title='{html.escape(title)}' sandbox='allow-scripts allow-downloads' "
        f"style='width:100%;height:640px;border:1px solid #8888;border-radius:8px' srcdoc=\"{html.escape(page)}\"></iframe>"
    )


def experiment(exp: Experiment) -> str:
    """An experiment in brief, with its whole text to unfold."""
    values = {
        "genes": exp.genes,
        "episodes of an individual": exp.trials,
        "control cycles": exp.cycles,
        "hash": exp.hash[:12],
    }
    text = html.escape(exp.to_toml())
    return facts(exp.name, values) + f"<details><summary>all settings</summary><pre>{text}</pre></details>"
