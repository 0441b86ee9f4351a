"""Planned gaits: curves, files, full states, repetition and export."""
