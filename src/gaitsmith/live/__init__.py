"""A page to watch and steer a walk, and to replay a run; the control loop runs in a process of its own."""
