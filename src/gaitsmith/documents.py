"""One reader for documents that a stranger wrote: cards, scenarios, motions, gaits."""
