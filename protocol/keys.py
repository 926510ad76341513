"""Redis keys, all in one place. Live state goes by channel; what is listed by name here is durable."""

PREFIX = "lilliput"

WAYPOINTS = f"{PREFIX}:waypoints"
"""Hash: waypoint id -> Waypoint."""
ROUTES = f"{PREFIX}:routes"
"""Hash: route id -> Route."""
ASSIGNMENTS = f"{PREFIX}:assignments"
"""Hash: robot id -> Assignment (its newest)."""
ROBOT_SETTINGS = f"{PREFIX}:robot_settings"
"""Hash: robot id -> RobotSettings."""
EXTRINSICS = f"{PREFIX}:extrinsics"
"""Hash: camera id -> CameraExtrinsics."""
CALIBRATIONS = f"{PREFIX}:calibrations"
"""Hash: `current`, `previous` -> Calibration over all cameras and floor tags."""
CALIBRATION_PROPOSALS = f"{PREFIX}:calibration_proposals"
"""Hash: `lab` -> CalibrationProposal that waits for a decision."""
SIMULATED_OBJECTS = f"{PREFIX}:simulated_objects"
"""Hash: object id -> SimulatedObject: what should stand on the simulated floor."""
SIMULATED_FAULTS = f"{PREFIX}:simulated_faults"
"""Hash: camera id -> CameraFault: what simulated cameras are made to suffer."""
SIMULATED_STATE = f"{PREFIX}:simulated_state"
"""Hash: vehicle id -> TruePose: where simulated vehicles stood, for a restart of the lab."""
USERS = f"{PREFIX}:users"
"""Hash: user name -> user record."""
TOKENS = f"{PREFIX}:tokens"
"""Hash: SHA-256 of a token -> token record."""
REDIS_USERS = f"{PREFIX}:redis_users"
"""Hash: robot id -> the record of the Redis user of a robot that speaks GPSS."""
GUIDANCE_EPOCH = f"{PREFIX}:guidance_epoch"
"""Counter: the fencing token of the newest guidance."""
GUIDANCE_LEASE = f"{PREFIX}:guidance_lease"
"""String with expiry: the epoch of the active guidance."""
PREVIEWS = f"{PREFIX}:previews"
"""Hash: camera id -> a small JPEG of its newest frame."""
FLOOR_TILES = f"{PREFIX}:floor_tiles"
"""Hash: camera id -> its view of the floor as FloorPicture bytes (JPEG with bounds)."""
FLOOR_PICTURE = f"{PREFIX}:floor_picture"
"""String: the stitched floor as JPEG; its bounds are FLOOR_PICTURE_BOUNDS."""
FLOOR_PICTURE_BOUNDS = f"{PREFIX}:floor_picture_bounds"
"""String: JSON [min x, min y, max x, max y] in metres."""


def session(digest: str) -> str:
    """String with expiry: a browser session, by the SHA-256 of its cookie."""
    return f"{PREFIX}:session:{digest}"


def live(channel: str) -> str:
    """Hash: instance -> newest message of a LATEST channel."""
    return f"{PREFIX}:live:{channel}"


def topic(channel: str, instance: str) -> str:
    """Pub/sub topic of one instance of a LATEST channel."""
    return f"{PREFIX}:topic:{channel}:{instance}"


def batch(channel: str) -> str:
    """Pub/sub topic of several instances of a LATEST channel at once: one JSON object, instance -> message."""
    return f"{PREFIX}:batch:{channel}"


def stream(channel: str) -> str:
    """Capped stream of an EVERY channel, all instances together."""
    return f"{PREFIX}:stream:{channel}"
