"""From sensor readings to the state: what is measured, filtered and estimated."""
