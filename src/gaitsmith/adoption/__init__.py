"""From a stranger's model to a card: inferred from geometry, tested in physics; begins in :mod:`adopting`."""
