"""Libraries of gaits: a grid that is planned, kept in a folder, and walked between its points."""
