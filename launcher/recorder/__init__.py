"""Makes recordings that `./lilliput localize` reads: of a simulated lab, rendered, and of cameras as they run."""
