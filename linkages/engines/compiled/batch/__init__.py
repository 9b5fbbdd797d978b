"""Many runs of one system with different values, in parallel threads, and their statistics.

| module            | responsibility                                                         |
|-------------------|------------------------------------------------------------------------|
| statistics        | runs of many designs in compiled code, and their statistics in windows |
| lengths           | designs with other lengths: their numbers without a system for each    |
| designs           | the designs of a batch as numbers                                      |
| runs              | `Runs`: runs of many designs in parallel threads, their derivatives    |
| batch             | `simulate_batch`: summaries of many runs                               |
"""
