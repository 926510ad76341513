"""What the service shows: pydantic models of the REST answers and the live stream, and pure functions that build them."""
