"""Guidance: routes, obstacle boxes and the safety of the fleet, as commands ten times a second (spec gpss)."""
