"""Write docs/misprints.md: ``python docs/make_misprints.py``."""

from __future__ import annotations

from pathlib import Path

from replication.misprints import page

PAGE = Path(__file__).with_name("misprints.md")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
