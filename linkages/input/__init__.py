"""Input: files are read and imported (`files`), give functions (`functions`), and become a validated `model`."""
