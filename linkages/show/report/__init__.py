"""Results for readers: one self-contained HTML page, a table for the terminal; runs and draws nothing.

| module        | responsibility                                                              |
|---------------|-----------------------------------------------------------------------------|
| result_folder | a folder written by ``linkages simulate`` -> `Results`, or a one-line error |
| words         | question and answer in sentences, commands that repeat the run              |
| page_tables   | tables: headings and cells, numbers as text                                 |
| page          | template, style, script and curves over time, or wear -> ``report.html``    |
| terminal      | a summary -> lines of text                                                  |

The page contains its figures and its animation as data. A content security policy in its head forbids the browser to
load anything else, so that the page stays unchanged for years.
"""

from typing import TYPE_CHECKING

import lazy_loader

# ruff: noqa: F401 - for type checkers, names that are loaded on first use below
if TYPE_CHECKING:
    from linkages.show.report.page import CONTENT, write_report, write_wear_report
    from linkages.show.report.result_folder import Results, load_results

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "page": ("CONTENT", "write_report", "write_wear_report"),
        "result_folder": ("Results", "load_results"),
    },
)
