"""The one list of commands. A command is a module in launcher/commands with `add_arguments(parser)` and `run(arguments)
-> exit status`; it is imported only when it is called, so `--help` is quick and `check` never loads OpenCV."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """One sub-command. With `takes_rest` everything behind the name reaches it unparsed as `arguments.rest`."""

    name: str
    summary: str
    takes_rest: bool = False

    @property
    def module(self) -> str:
        return f"launcher.commands.{self.name.replace('-', '_')}"


COMMANDS = (
    Command("up", "start the whole system for a lab and open the console"),
    Command("run", "run one process of the system in the foreground (containers, several machines)"),
    Command("stop", "stop every robot at once, also when the server is dead"),
    Command("user", "list, add and remove users of the console, set their passwords"),
    Command("token", "list, issue and revoke API tokens for programs and robots"),
    Command("detect", "find AprilTags in pictures"),
    Command("localize", "turn recorded videos or pictures of a lab's cameras into poses"),
    Command("record", "record the cameras of a simulated or running lab"),
    Command("bench", "measure how fast a part is, beside the published methods"),
    Command("calibrate", "calibrate cameras and floor tags: of a running system, or from recordings"),
    Command("experiment", "run an experiment in the simulated lab and print its figures"),
    Command("logs", "where the time of the frames went: runs compared, box plots, time graphs"),
    Command("test", "run all tests, browser tests included; further arguments go to pytest", takes_rest=True),
    Command("generate", "write the sources that are generated from others (API types of the console)"),
    Command("check", "format, lint, types, import rules, generated files, web sources"),
)
