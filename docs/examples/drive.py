"""Sends a robot around a square through Lilliput's REST API.

    LILLIPUT_TOKEN=... python docs/examples/drive.py wifibot-14

The token needs the role "operator": ./lilliput token issue my-script --role operator
"""

import argparse
import os
import sys
import time

import httpx

SQUARE = [(1.0, 1.0), (2.2, 1.0), (2.2, 2.0), (1.0, 2.0)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot")
    parser.add_argument("--server", default="http://127.0.0.1:8000")
    parser.add_argument("--area", default="camp")
    parser.add_argument("--timeout", type=float, default=120.0, help="seconds until the route must be done")
    arguments = parser.parse_args()
    token = os.environ.get("LILLIPUT_TOKEN")
    headers = {"Authorization": f"Bearer {token}"} if token else {}

    with httpx.Client(base_url=f"{arguments.server}/api", headers=headers, timeout=10) as api:
        legs: list[dict[str, object]] = []
        for number, (x, y) in enumerate(SQUARE, start=1):
            waypoint = {"id": f"square-{number}", "area": arguments.area, "x": x, "y": y, "radius_m": 0.2}
            put(api, f"/waypoints/{waypoint['id']}", waypoint)
            legs.append({"waypoint": waypoint["id"], "speed_mps": 0.3})
        put(api, "/routes/square", {"id": "square", "legs": legs})
        put(api, f"/robots/{arguments.robot}/assignment", {"route": "square"})

        deadline, shown = time.monotonic() + arguments.timeout, None
        while time.monotonic() < deadline:
            robot = api.get(f"/robots/{arguments.robot}").raise_for_status().json()
            leg, state = robot["assignment"]["leg"], robot["assignment"]["state"]
            why = "{code} {text}".format(**robot["reason"]) if robot["reason"] else ""
            if (leg, state, why) != shown:
                shown = (leg, state, why)
                print(f"{state}, leg {leg + 1} of {len(legs)}: {why}")
            if state not in ("running", "paused"):
                return 0 if state == "done" else 1
            time.sleep(0.2)
        api.delete(f"/robots/{arguments.robot}/assignment")
        print("not done in time; stopped the robot", file=sys.stderr)
        return 1


def put(api: httpx.Client, path: str, body: object) -> None:
    answer = api.put(path, json=body)
    if answer.is_error:
        sys.exit(f"PUT {path}: {answer.status_code} {answer.json()['detail']}")


if __name__ == "__main__":
    sys.exit(main())
