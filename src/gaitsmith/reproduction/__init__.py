"""Both papers' figures made again: the experiment behind each, its picture, and what the paper says beside it."""
