"""`./lilliput token`: API tokens for programs and robots of a system that runs, and Redis users of robots that speak GPSS.

`token issue` prints the token alone to stdout, so that a script can keep it; it is shown nowhere else. `token redis` prints
user and password, with a space between.
"""

import argparse
from datetime import UTC, datetime

import redis.asyncio

from launcher.errors import UsageError
from launcher.lab_file import add_lab_arguments, read_lab
from launcher.output import Result, print_result, progress
from launcher.running_redis import with_redis
from protocol.gpss import user_name
from protocol.lab import GPSS_DRIVER
from server.auth import Role, Token, issue_token, list_tokens, revoke_token
from server.gpss.access import issue_redis_user, revoke_redis_user


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(metavar="ACTION", required=True)
    issue = actions.add_parser("issue", help="make a token and print it")
    issue.add_argument("name", help="what it is for, e.g. night-shift-script")
    issue.add_argument("--role", choices=[str(role) for role in Role], default="operator", help="default: operator")
    issue.add_argument("--robot", metavar="ID", help="the robot that a token of role robot speaks for")
    issue.add_argument("--replace", action="store_true", help="make the present token of that name void")
    issue.set_defaults(act=_issue)
    listed = actions.add_parser("list", help="show all tokens, without their texts")
    listed.set_defaults(act=_list)
    revoke = actions.add_parser("revoke", help="make a token void")
    revoke.add_argument("name", help="its name or id")
    revoke.set_defaults(act=_revoke)
    redis_user = actions.add_parser("redis", help="make the Redis user of a robot that speaks GPSS, and print it")
    redis_user.add_argument("robot", metavar="ROBOT", help=f"a vehicle whose driver is {GPSS_DRIVER}")
    redis_user.add_argument("--replace", action="store_true", help="make its present password void")
    redis_user.add_argument("--revoke", action="store_true", help="end the user instead")
    redis_user.set_defaults(act=_redis)
    for action in (issue, listed, revoke, redis_user):
        add_lab_arguments(action)
        action.add_argument("--json", action="store_true", help="print one JSON object to stdout")


def run(arguments: argparse.Namespace) -> int:
    arguments.act(arguments)
    return 0


def _issue(arguments: argparse.Namespace) -> None:
    async def work(client: redis.asyncio.Redis) -> str:
        return await issue_token(client, arguments.name, arguments.role, arguments.robot, replace=arguments.replace)

    token = with_redis(arguments, work)
    if arguments.json:
        settings = {"name": arguments.name, "role": arguments.role, "robot": arguments.robot}
        print_result(Result("token", {"token": token}, settings=settings), as_json=True)
    else:
        progress(f"token {arguments.name} of role {arguments.role}, shown only this once:")
        print(token, flush=True)


def _list(arguments: argparse.Namespace) -> None:
    tokens = with_redis(arguments, list_tokens)
    if arguments.json:
        figures = {
            token.id: {
                "name": token.name,
                "role": str(token.role),
                "robot": token.robot,
                "created_ns": token.created_ns,
                "last_used_ns": token.last_used_ns,
            }
            for token in tokens
        }
        print_result(Result("tokens", {"tokens": figures}), as_json=True)
        return
    for token in tokens:
        print(_line(token))


def _revoke(arguments: argparse.Namespace) -> None:
    async def work(client: redis.asyncio.Redis) -> None:
        await revoke_token(client, arguments.name)

    with_redis(arguments, work)
    if arguments.json:
        print_result(Result("token", {"revoked": arguments.name}), as_json=True)
    else:
        progress(f"token {arguments.name} is void")


def _redis(arguments: argparse.Namespace) -> None:
    _, lab = read_lab(arguments.lab)
    robots = [vehicle.id for vehicle in lab.vehicles if vehicle.driver == GPSS_DRIVER]
    robot: str = arguments.robot
    if robot not in robots:
        raise UsageError(
            f"{robot!r} is no vehicle with driver {GPSS_DRIVER} in lab {lab.name}; there is {', '.join(robots) or 'none'}"
        )
    if arguments.revoke:
        with_redis(arguments, lambda client: revoke_redis_user(client, robot))
        if arguments.json:
            print_result(Result("token", {"revoked": user_name(robot)}), as_json=True)
        else:
            progress(f"the Redis user of {robot} is void")
        return
    user, password = with_redis(arguments, lambda client: issue_redis_user(client, robot, replace=arguments.replace))
    if arguments.json:
        print_result(Result("token", {"user": user, "password": password}, settings={"robot": robot}), as_json=True)
    else:
        progress(f"Redis user and password of {robot}, shown only this once:")
        print(user, password, flush=True)


def _line(token: Token) -> str:
    role = f"{token.role} {token.robot}" if token.robot else str(token.role)
    used = f"last used {_day(token.last_used_ns)}" if token.last_used_ns else "never used"
    return f"{token.id}  {token.name:<24} {role:<20} made {_day(token.created_ns)} by {token.created_by}, {used}"


def _day(stamp_ns: int) -> str:
    return datetime.fromtimestamp(stamp_ns / 1e9, UTC).astimezone().strftime("%Y-%m-%d %H:%M")
