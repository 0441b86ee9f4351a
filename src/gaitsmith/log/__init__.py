"""The log of a run: rows, an MCAP file on disk, and the way back."""

from gaitsmith.log.record import Log as Log
from gaitsmith.log.record import read_log as read_log
