"""What a run, a demo or a film shows to people: one self-contained page, figures, a video."""
