"""Logs of flights that really happened, as they come from flight controllers, simulators and spreadsheets."""
