"""Recorded cameras turned into poses (spec localization; design, "Recordings"): the same pipeline and tracker as live, with
the calibration that the whole recording gives."""
