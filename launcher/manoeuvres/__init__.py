"""Traffic scenes: vehicles that drive along their ways and meet in zones, with minds that decide how fast, over a network that
fails."""
