"""The simulated lab: a world of vehicles, people and pallets, and ceiling cameras whose frames are rendered from it."""
