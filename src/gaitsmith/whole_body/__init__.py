"""From references to joint torques: frames, tasks, contact wrenches, and the quadratic program over them."""
