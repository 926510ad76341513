"""When a camera may take what it sees for floor."""

import pytest

from localization.robots_in_view import RobotsInView
from protocol.messages import TrackedPose

S = 1_000_000_000


def pose(name: str, stamp_ns: int) -> TrackedPose:
    return TrackedPose(name, stamp_ns, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-4), ("cam0",))


@pytest.fixture
def view() -> RobotsInView:
    """A camera that has searched its whole picture and seen nobody."""
    view = RobotsInView()
    view.note(0, [], full_search=True)
    return view


def test_nothing_is_known_before_the_whole_picture_was_searched() -> None:
    view = RobotsInView()
    assert not view.are_known({})
    view.note(0, [], full_search=False)
    assert not view.are_known({})
    view.note(S // 15, [], full_search=True)
    assert view.are_known({})


def test_a_robot_in_view_is_known_while_its_pose_is_fresh(view: RobotsInView) -> None:
    view.note(S, ["a"], full_search=False)
    assert not view.are_known({})
    assert not view.are_known({"b": pose("b", S)})
    assert view.are_known({"a": pose("a", S - S // 4)})
    assert not view.are_known({"a": pose("a", S // 3)})


def test_a_robot_whose_tag_is_not_seen_in_every_frame_is_not_forgotten(view: RobotsInView) -> None:
    view.note(S // 2, ["a"], full_search=False)
    for tenth in range(6, 600):
        view.note(tenth * S // 10, [], full_search=True)
        assert not view.are_known({})
    assert view.are_known({"a": pose("a", 60 * S)}), "it is tracked, here or before another camera"
    view.note(61 * S, [], full_search=True)
    assert view.are_known({}), "it was carried away"


@pytest.mark.parametrize("stamp_ns", [20 * S, -20 * S])
def test_after_a_gap_the_picture_must_be_searched_again(view: RobotsInView, stamp_ns: int) -> None:
    assert view.are_known({})
    view.note(stamp_ns, [], full_search=False)
    assert not view.are_known({}), "somebody may have driven there meanwhile"
    view.note(stamp_ns + S // 15, [], full_search=True)
    assert view.are_known({})
