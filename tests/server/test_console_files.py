"""The console's files, headers, pictures, and the answers while Redis is away."""

from pathlib import Path

import pytest
import redis

from protocol import keys
from tests.redis_fixture import RedisServer
from tests.server.service import PASSWORD, ROBOT, in_process, until


async def test_without_a_build_the_page_says_so(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        page = await service.http().get("/")
        assert page.status_code == 503
        assert "not built yet" in page.text


async def test_the_console_is_served(redis_url: str, tmp_path: Path) -> None:
    dist = tmp_path / "dist"
    (dist / "assets").mkdir(parents=True)
    (dist / "index.html").write_text("<html>console</html>")
    (dist / "favicon.svg").write_text("<svg/>")
    (dist / "assets" / "index-abc123.js").write_text("1")
    (tmp_path / "secret.txt").write_text("hidden")
    async with in_process(redis_url, console=dist) as service:
        client = service.http()
        for path in ("/", "/robots", "/routes/charge?x=1", "/viserious"):
            page = await client.get(path)
            assert (page.status_code, page.text) == (200, "<html>console</html>")
            assert page.headers["cache-control"] == "no-cache"
        script = await client.get("/assets/index-abc123.js")
        assert script.headers["cache-control"] == "public, max-age=31536000, immutable"
        assert "javascript" in script.headers["content-type"]
        assert (await client.get("/favicon.svg")).headers["content-type"] == "image/svg+xml"
        assert (await client.get("/assets/old-build.js")).status_code == 404
        for path in ("/api", "/api/nothing"):
            answer = await client.get(path)
            assert (answer.status_code, list(answer.json())) == (404, ["detail"])
        for path in (
            "/..%2fsecret.txt",
            "/%2e%2e/secret.txt",
            "/assets/..%2f..%2fsecret.txt",
            "/%00",
            "/" + "a" * 5000,
        ):
            answer = await client.get(path)
            assert "hidden" not in answer.text, path
            assert answer.status_code in (200, 404)


async def test_headers_protect_the_console(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        for path in ("/", "/api/health", "/api/lab", "/viser/"):
            headers = (await service.http().get(path)).headers
            assert headers["x-content-type-options"] == "nosniff"
            assert "frame-ancestors 'self'" in headers["content-security-policy"]
        policy = (await service.http().get("/")).headers["content-security-policy"]
        assert "script-src 'self';" in policy
        assert "ws://console " in policy
        sneaky = await service.http().get("/", headers={"Host": "x; script-src *"})
        assert "script-src *" not in sneaky.headers["content-security-policy"]
        assert (await service.http("viewer").get("/api/lab")).headers["cache-control"] == "no-store"


async def test_pictures(redis_server: RedisServer) -> None:
    with redis.Redis.from_url(redis_server.url) as stored:
        async with in_process(redis_server.url) as service:
            viewer = service.http("viewer")
            missing = await viewer.get("/api/cameras/cam0/preview.jpg")
            assert (missing.status_code, missing.json()["detail"]) == (404, "cam0 has not sent a picture yet")
            assert (await viewer.get("/api/cameras/cam9/preview.jpg")).status_code == 404
            assert (await viewer.get("/api/floor.jpg")).status_code == 404
            stored.hset(keys.PREVIEWS, "cam0", b"\xff\xd8first")
            stored.mset({keys.FLOOR_PICTURE: b"\xff\xd8floor", keys.FLOOR_PICTURE_BOUNDS: "[-0.35, -0.3, 8.35, 4.6]"})
            picture = await viewer.get("/api/cameras/cam0/preview.jpg")
            assert (picture.content, picture.headers["content-type"]) == (b"\xff\xd8first", "image/jpeg")
            again = {"If-None-Match": picture.headers["etag"]}
            assert (await viewer.get("/api/cameras/cam0/preview.jpg", headers=again)).status_code == 304
            stored.hset(keys.PREVIEWS, "cam0", b"\xff\xd8second")
            assert (await viewer.get("/api/cameras/cam0/preview.jpg", headers=again)).content == b"\xff\xd8second"
            floor = await viewer.get("/api/floor.jpg")
            assert (floor.content, floor.headers["x-bounds"]) == (b"\xff\xd8floor", "-0.35,-0.3,8.35,4.6")


async def test_the_lab_without_secrets(redis_url: str) -> None:
    from tests.server.service import gulliver

    lab = gulliver()
    camera = lab.cameras[0].model_copy(update={"source": "rtsp://eva:pa55word@camera/stream"})
    async with in_process(redis_url, lab=lab.model_copy(update={"cameras": (camera, *lab.cameras[1:])})) as service:
        for path in ("/api/lab", "/api/cameras"):
            text = (await service.http("viewer").get(path)).text
            assert "pa55word" not in text
            assert "rtsp://camera/stream" in text
        shown = (await service.http("viewer").get("/api/lab")).json()
        assert "simulation" not in shown
        assert shown["simulated"] is True


async def test_without_redis_every_route_says_so_and_recovers(redis_server: RedisServer) -> None:
    reads = [
        "/session",
        "/robots",
        f"/robots/{ROBOT}",
        "/waypoints",
        "/routes",
        "/estop",
        "/cameras",
        "/events",
        "/users",
    ]
    reads += ["/tokens", "/floor.jpg", "/cameras/cam0/preview.jpg", "/sim/objects", "/lab", f"/robots/{ROBOT}/commands"]
    async with in_process(redis_server.url) as service:
        admin = service.http("admin")
        assert (await admin.get("/api/session")).status_code == 200
        redis_server.kill()
        for path in reads:
            answer = await admin.get(f"/api{path}")
            assert answer.status_code == 503, path
            assert "Redis is out of reach" in answer.json()["detail"]
        waypoint = {"id": "a", "area": "camp", "x": 1, "y": 1}
        writes = [
            admin.post("/api/waypoints", json=waypoint),
            admin.post("/api/estop", json={}),
            admin.put(f"/api/robots/{ROBOT}/manual", json={"linear_mps": 0, "angular_radps": 0}),
            service.http("robot").post(f"/api/robots/{ROBOT}/registration", json={"udp_port": 1}),
            service.http().post("/api/session", json={"user": "admin", "password": PASSWORD}),
        ]
        for request in writes:
            assert (await request).status_code == 503
        health = await admin.get("/api/health")
        assert health.status_code == 200
        assert health.json()["state"] == "error"
        assert health.json()["redis"]["reachable"] is False
        redis_server.start()
        for path in reads[:9]:
            assert (await admin.get(f"/api{path}")).status_code == 200, path
        assert (await admin.post("/api/waypoints", json=waypoint)).status_code == 201

        async def well_again() -> bool:
            return (await admin.get("/api/health")).json()["redis"]["reachable"]

        await until(well_again)


@pytest.mark.parametrize("body", [b"", b"{", b"[]", b"null", b'{"id": "a"}', b"\xff\xfe", b'{"a":' * 5000])
async def test_bodies_that_make_no_sense(redis_url: str, body: bytes) -> None:
    async with in_process(redis_url) as service:
        headers = {"Content-Type": "application/json"}
        answer = await service.http("operator").post("/api/waypoints", content=body, headers=headers)
        assert answer.status_code in (400, 422)
        assert (await service.http("viewer").get("/api/waypoints")).json() == []


async def test_bodies_that_are_too_large(redis_url: str) -> None:
    async with in_process(redis_url) as service:
        answer = await service.http().post("/api/session", content=b" " * (2 << 20))
        assert answer.status_code == 413
