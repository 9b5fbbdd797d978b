"""Write docs/replication_3rrr.md: ``python docs/make_replication_3rrr.py``."""

from __future__ import annotations

from pathlib import Path

from replication.three_rrr import page, rows

from linkages.files.shipped import find_file
from linkages.three_rrr.robot import load_robot

PAGE = Path(__file__).with_name("replication_3rrr.md")


if __name__ == "__main__":
    robot = load_robot(find_file("three_rrr.toml"))
    PAGE.write_text(page(robot, rows(robot)), encoding="utf-8")
