"""One instant of a gait: its numbers and their derivatives, compiled when a C compiler is present."""
