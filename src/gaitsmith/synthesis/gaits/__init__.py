"""Planned gaits: curves, full states, steps unrolled, ZMP and support, plans for the controller."""
