"""Results for readers: one self-contained HTML page, a table for the terminal; runs and draws nothing.

| module        | responsibility                                                              |
|---------------|-----------------------------------------------------------------------------|
| result_folder | a folder written by ``linkages simulate`` -> `Results`, or a one-line error |
| answer        | the question of a run, its answer in sentences, remarks                     |
| units         | the numbers of a summary in the units that tables show                      |
| words         | units, changes, the final motion, commands that repeat the run              |
| tables        | tables as data: of records, and of the commands that write them             |
| page_tables   | tables of a run: headings and cells, numbers as text                        |
| page          | template, style, script and curves over time of a run -> ``report.html``    |
| result_page   | record, figures and animation of another command -> ``report.html``         |
| terminal      | a summary -> lines of text                                                  |

The page contains its figures and its animation as data. A content security policy in its head forbids the browser to
load anything else, so that the page stays unchanged for years.
"""
