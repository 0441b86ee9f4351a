"""Files: gaits written and read, motions read, rows exported."""
