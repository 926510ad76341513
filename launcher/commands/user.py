"""`./lilliput user`: who may log in to the console of a system that runs.

Passwords are made at random and printed once, or asked for with `--ask`; never taken from the command line, where other
users of the machine could read them.
"""

import argparse
import getpass
import sys

import redis.asyncio

from launcher.errors import UsageError
from launcher.lab_file import add_lab_arguments
from launcher.output import Result, print_result, progress
from launcher.running_redis import with_redis
from server.auth import Role, create_user, delete_user, list_users, set_password
from server.auth.passwords import readable_password

ROLES = [str(role) for role in Role if role is not Role.ROBOT]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(metavar="ACTION", required=True)
    add = actions.add_parser("add", help="make a user")
    add.add_argument("--role", choices=ROLES, default="operator", help="default: operator")
    add.set_defaults(act=_add)
    password = actions.add_parser("password", help="set a user's password and end the user's sessions")
    password.set_defaults(act=_password)
    remove = actions.add_parser("remove", help="remove a user")
    remove.set_defaults(act=_remove)
    listed = actions.add_parser("list", help="show all users")
    listed.set_defaults(act=_list)
    for action in (add, password, remove):
        action.add_argument("name")
    for action in (add, password):
        action.add_argument("--ask", action="store_true", help="ask for the password (or read it from a pipe)")
    for action in (add, password, remove, listed):
        add_lab_arguments(action)
        action.add_argument("--json", action="store_true", help="print one JSON object to stdout")


def run(arguments: argparse.Namespace) -> int:
    arguments.act(arguments)
    return 0


def _add(arguments: argparse.Namespace) -> None:
    password = _chosen_password(arguments)

    async def work(client: redis.asyncio.Redis) -> None:
        await create_user(client, arguments.name, arguments.role, password)

    with_redis(arguments, work)
    _tell(arguments, f"user {arguments.name} of role {arguments.role} may log in", password)


def _password(arguments: argparse.Namespace) -> None:
    password = _chosen_password(arguments)

    async def work(client: redis.asyncio.Redis) -> None:
        await set_password(client, arguments.name, password)

    with_redis(arguments, work)
    _tell(arguments, f"user {arguments.name} has a new password", password)


def _remove(arguments: argparse.Namespace) -> None:
    async def work(client: redis.asyncio.Redis) -> None:
        await delete_user(client, arguments.name)

    with_redis(arguments, work)
    if arguments.json:
        print_result(Result("user", {"removed": arguments.name}), as_json=True)
    else:
        progress(f"user {arguments.name} is removed")


def _list(arguments: argparse.Namespace) -> None:
    users = with_redis(arguments, list_users)
    if arguments.json:
        print_result(Result("users", {"users": {user.name: str(user.role) for user in users}}), as_json=True)
        return
    for user in users:
        print(f"{user.name:<24} {user.role}")


def _chosen_password(arguments: argparse.Namespace) -> str:
    if not arguments.ask:
        return readable_password()
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\n")
    password = getpass.getpass("Password: ")
    if getpass.getpass("Again: ") != password:
        raise UsageError("the two passwords differ; nothing was changed")
    return password


def _tell(arguments: argparse.Namespace, text: str, password: str) -> None:
    made = {} if arguments.ask else {"password": password}
    if arguments.json:
        print_result(Result("user", {"user": arguments.name, **made}), as_json=True)
        return
    progress(text + ("" if arguments.ask else ", with this password, shown only this once:"))
    if made:
        print(password, flush=True)
