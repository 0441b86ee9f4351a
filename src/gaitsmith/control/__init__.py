"""From measurement to joint torques: inverse kinematics, whole-body QP, touchdown, estimation, one Controller."""
