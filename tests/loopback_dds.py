"""DDS that stays on this machine: no multicast, the loopback alone, participants find one another by 127.0.0.1's ports."""

import os

URI = (
    "<CycloneDDS><Domain><General>"
    '<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>30</MaxAutoParticipantIndex>"
    '<Peers><Peer address="127.0.0.1"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)


def stay_on_loopback() -> None:
    """For this process and its children; before the first participant."""
    os.environ["CYCLONEDDS_URI"] = URI


def domain_of_this_run() -> int:
    """A DDS domain (1..199) that other runs on this machine hardly have."""
    return 1 + os.getpid() % 199
