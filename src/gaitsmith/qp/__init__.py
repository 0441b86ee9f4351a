"""Small dense quadratic programs, solved from the last active set."""
