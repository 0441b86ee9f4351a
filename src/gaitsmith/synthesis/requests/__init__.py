"""What a user asks for: a named motion, a motion file or a grid of gaits, and the document that answers."""
