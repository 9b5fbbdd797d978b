"""Input: files are read, imported and written (`files`), and become a validated machine and experiment (`model`)."""
