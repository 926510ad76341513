"""The scene as a service: a viser server on loopback and a loop that draws the world at a steady rate."""

import asyncio
import logging

import viser

from protocol.bus import Bus
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.lifetime import run_until_signal
from server.scene import layer_fleet, layer_floor, layer_plan
from server.scene.canvas import Canvas
from server.scene.feed import Feed
from server.scene.world import FloorPicture, World

_logger = logging.getLogger(__name__)
HOST = "127.0.0.1"
_RATE_HZ = 15.0
_UNWATCHED_HZ = 2.0
"""While nobody looks: so old is what who connects sees first."""
_OBSTACLES_EVERY_S = 0.2
_SLOW_EVERY_S = 0.5
_PICTURE_EVERY_S = 1.0
_VIEW_RAD = 0.75


class PortTakenError(Exception):
    """viser would silently listen on another port, where nobody looks for it."""


class PrivateServer(viser.ViserServer):
    """A viser server that stays on this machine: any page could otherwise ask viser to publish it through its makers' relay."""

    def request_share_url(self, verbose: bool = True) -> str | None:  # noqa: ARG002  # viser's signature
        _logger.warning("refused to publish the scene through a relay")
        return None


def open_server(port: int) -> viser.ViserServer:
    """A viser server on loopback at exactly that port; PortTakenError when it is in use."""
    server = PrivateServer(host=HOST, port=port, label="Lilliput", verbose=False)
    if server.get_port() != port:
        got = server.get_port()
        server.stop()
        raise PortTakenError(
            f"port {port} on {HOST} is in use (the scene would get {got}); free it or set another ports.scene in the lab file"
        )
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(56, 189, 248))
    server.gui.main_panel.minimize()
    return server


class Scene:
    """Draws the world on a viser server."""

    def __init__(self, lab: Lab, server: viser.ViserServer, world: World, clock: Clock) -> None:
        self._lab, self._server, self._world, self._clock = lab, server, world, clock
        self.canvas = Canvas(server.scene)
        self._next_obstacles_s = self._next_slow_s = self._next_picture_s = 0.0
        self._picture: FloorPicture | None = None
        self.pictures_sent = 0
        self._set_stage()

    def update(self) -> None:
        """One picture of the world: robots and boxes each time, the rest less often. The floor's picture is apart."""
        now_ns, now_s = self._clock.now_ns(), self._clock.monotonic_s()
        world, lab, canvas = self._world, self._lab, self.canvas
        with self._server.atomic():
            layer_fleet.draw_robots(canvas, lab, world, now_ns)
            layer_plan.draw_guidance(canvas, world.guidance, now_ns)
            if now_s >= self._next_obstacles_s:
                self._next_obstacles_s = now_s + _OBSTACLES_EVERY_S
                layer_plan.draw_obstacles(canvas, world.obstacles, now_ns)
            if now_s >= self._next_slow_s:
                self._next_slow_s = now_s + _SLOW_EVERY_S
                layer_fleet.draw_cameras(canvas, lab, world.extrinsics, world.cameras, now_ns)
                layer_plan.draw_waypoints(canvas, world.waypoints)
                layer_plan.draw_routes(canvas, world.routes, world.waypoints)

    async def update_picture(self) -> None:
        """The floor's picture, at most once a second and only when it is another one; coded in a thread of its own."""
        now_s, picture = self._clock.monotonic_s(), self._world.picture
        if picture is None or picture == self._picture or now_s < self._next_picture_s:
            return
        self._next_picture_s = now_s + _PICTURE_EVERY_S
        self._picture = picture
        pixels = await asyncio.to_thread(layer_floor.decoded, picture)
        if pixels is None:
            _logger.warning("the floor picture is no image of %d bytes", len(picture.jpeg))
            return
        await asyncio.to_thread(layer_floor.add_picture, self._server.scene, picture, pixels)
        self.pictures_sent += 1

    async def run(self) -> None:
        """Draws until cancelled."""
        next_s = self._clock.monotonic_s()
        while True:
            self.update()
            rate_hz = _RATE_HZ if self._server.get_clients() else _UNWATCHED_HZ
            next_s = max(next_s + 1 / rate_hz, self._clock.monotonic_s())
            await self._clock.sleep(next_s - self._clock.monotonic_s())

    async def run_picture(self) -> None:
        """Keeps the floor's picture up to date until cancelled."""
        while True:
            await self.update_picture()
            await self._clock.sleep(_PICTURE_EVERY_S / 4)

    def _set_stage(self) -> None:
        """Light, the first view of those who connect, and all that never moves."""
        scene = self._server.scene
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        min_x, min_y, max_x, max_y = self._lab.bounds()
        x, y = (min_x + max_x) / 2, (min_y + max_y) / 2
        extent = max(max_x - min_x, (max_y - min_y) * 1.4)
        # viser's own lights wash dark floors out: a soft sky and one lamp that casts short shadows instead.
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False)
        scene.add_light_hemisphere("/light/sky", sky_color=(235, 242, 255), ground_color=(90, 96, 110), intensity=2.4)
        scene.add_light_directional("/light/lamp", intensity=2.6, position=(-0.5, -0.8, 2.2), cast_shadow=True)
        camera = self._server.initial_camera
        camera.fov = _VIEW_RAD
        camera.position = (x, y - 0.78 * extent, 0.74 * extent)
        camera.look_at = (x, y, 0.05 * extent)
        camera.up = (0.0, 0.0, 1.0)
        layer_floor.draw_lab(self.canvas, self._lab)


async def serve(lab: Lab, server: viser.ViserServer, bus: Bus, clock: Clock) -> None:
    """Feeds and draws until a signal."""
    world = World()
    scene, feed = Scene(lab, server, world, clock), Feed(world, bus, clock)
    await run_until_signal(feed.follow(), feed.poll(), scene.run(), scene.run_picture())
