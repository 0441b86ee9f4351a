"""From measurement to joint torques: inverse kinematics, whole-body QP, touchdown, estimation, one Controller."""

from gaitsmith.control.controller import Controller as Controller
from gaitsmith.control.storage import CONTROL_PERIOD as CONTROL_PERIOD
from gaitsmith.control.telemetry import Telemetry as Telemetry
from gaitsmith.estimation.measurement import Measurement as Measurement
from gaitsmith.kinematics.posture import standing_posture as standing_posture
