"""Planned motions as arrays: contact schedule, curves of all tracked quantities, and the law that follows them."""

from gaitsmith.planned.schedule import ContactPhase as ContactPhase
from gaitsmith.planned.schedule import Schedule as Schedule
from gaitsmith.planned.table import Plan as Plan
from gaitsmith.planned.table import PlanTable as PlanTable
