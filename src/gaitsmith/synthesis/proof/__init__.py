"""What physics says of a gait: the certificate recomputed, the replay, the paper's claims."""
