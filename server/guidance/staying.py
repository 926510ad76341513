"""Stops of a route: what a robot stays for at the end of a leg, and when it may go on (spec gpss: pick-up, drop-off, charge)."""

from protocol.messages import Assignment, Leg, Reason, ReasonCode, StopAction
from server.guidance.snapshot import Heard

_DOING = {
    StopAction.PICK_UP: "picks up",
    StopAction.DROP_OFF: "drops off",
    StopAction.CHARGE: "charges",
}


def reason_to_stay(leg: Leg, assignment: Assignment, status: Heard | None, now_ns: int) -> Reason | None:
    """Why the robot still stays at the end of `leg`, None when it may go on: after its dwell time, with its battery charged if
    it charges and says how much it has, and confirmed if somebody is to do that. A person may let it go on at any time."""
    if assignment.at_stop_ns is None or assignment.proceed:
        return None
    doing = f"{_DOING[leg.action]} at {leg.waypoint}" if leg.action is not None else f"stays at {leg.waypoint}"
    left_s = leg.dwell_s - (now_ns - assignment.at_stop_ns) / 1e9
    battery = status.battery if status is not None else None
    if leg.action is StopAction.CHARGE and battery is not None and battery < leg.charge_to:
        return _stay(f"{doing}: {battery:.0%} of {leg.charge_to:.0%}")
    if left_s > 0:
        return _stay(f"{doing}, {left_s:.0f} s left")
    if leg.confirm:
        return _stay(f"{doing} until a person lets it go on")
    return None


def _stay(text: str) -> Reason:
    return Reason(code=ReasonCode.AT_STOP, text=text)
