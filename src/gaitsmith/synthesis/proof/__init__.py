"""What physics says of a gait: the certificate recomputed, the paper's claims."""
