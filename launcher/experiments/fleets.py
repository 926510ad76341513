"""Labs with more vehicles than they describe: as many as an experiment wants, each with a tag of its own."""

from protocol.lab import Lab, VehicleSpec


def with_fleet(lab: Lab, count: int) -> Lab:
    """The lab with `count` vehicles made after its own in turn: same kinds, sizes and heights; their ids are those of a family
    that neither floor tags nor each other use. ValueError when the lab has no vehicle to make others after."""
    if not lab.vehicles:
        raise ValueError(f"lab {lab.name} has no vehicle to make a fleet after")
    taken = set(lab.floor_tags.poses)
    free = (tag_id for tag_id in range(10_000) if tag_id not in taken)
    vehicles: list[VehicleSpec] = []
    for number in range(count):
        pattern = lab.vehicles[number % len(lab.vehicles)]
        tag = pattern.tag.model_copy(update={"id": next(free)})
        vehicles.append(pattern.model_copy(update={"id": f"{pattern.kind}-{number}", "tag": tag}))
    simulation = lab.simulation.model_copy(update={"starts": {}, "tours": {}})
    return lab.model_copy(update={"vehicles": tuple(vehicles), "simulation": simulation})
