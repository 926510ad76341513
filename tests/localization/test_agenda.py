"""When a joint calibration is due."""

from localization.agenda import Agenda
from protocol.lab import camera_basis, floor_basis
from protocol.messages import CalibratedCamera, Calibration, CalibrationRun, RunState
from tests.localization.sightings import LAB, message, sighting

S = 1_000_000_000
NOW = 1_700_000_000 * S


def calibration(stamp_ns: int, *cameras: str) -> Calibration:
    return Calibration(
        id=1,
        stamp_ns=stamp_ns,
        by="calibrator",
        floor_basis=floor_basis(LAB.floor_tags),
        cameras={
            name: CalibratedCamera(
                rotvec=(3.1, 0.0, 0.0),
                translation=(0.0, 0.0, 2.0),
                reprojection_px=0.1,
                floor_tags=(0, 1),
                basis=camera_basis(LAB.camera(name)),
            )
            for name in cameras
        },
        floor_tags={},
    )


def agenda(**extrinsics_ns: int) -> Agenda:
    """Cameras that calibrated themselves at these times."""
    return Agenda(LAB, {name: message(sighting(name, ns), ns) for name, ns in extrinsics_ns.items()})


def test_a_first_calibration_waits_for_all_cameras_but_not_for_ever() -> None:
    assert agenda(left=NOW - 2 * S, right=NOW - 2 * S).unrefined(None, NOW) == ("left", "right")
    assert agenda(left=NOW - 2 * S, right=NOW).unrefined(None, NOW) == (), "not settled"
    assert agenda(left=NOW - 2 * S).unrefined(None, NOW) == ()
    assert agenda(left=NOW - 11 * S).unrefined(None, NOW) == ("left",)


def test_only_a_camera_that_found_its_place_after_the_result_came_into_force_is_refined_again() -> None:
    known = calibration(NOW - 20 * S, "left", "right")
    assert agenda(left=NOW - 30 * S, right=NOW - 20 * S).unrefined(known, NOW) == ()
    assert agenda(left=NOW - 30 * S, right=NOW - 10 * S).unrefined(known, NOW) == ("right",)
    assert agenda(left=NOW - 30 * S, right=NOW - 30 * S).unrefined(calibration(NOW, "left"), NOW) == ("right",)

    asked = agenda(left=NOW - 30 * S)
    asked.sightings["right"] = message(sighting("right", NOW - 5 * S), NOW - 5 * S, request=7)
    assert asked.unrefined(known, NOW) == (), "a person decides about it"


def test_a_result_holds_as_far_as_the_lab_description_is_the_same() -> None:
    known = calibration(NOW, "left", "right")
    wider = LAB.camera("right").model_copy(update={"width": 1920})
    changed = LAB.model_copy(update={"cameras": (LAB.camera("left"), wider)})
    held = Agenda(changed).still_holds(known)
    assert held is not None
    assert set(held.cameras) == {"left"}
    moved = LAB.floor_tags.model_copy(update={"size_m": 0.2})
    assert Agenda(LAB.model_copy(update={"floor_tags": moved})).still_holds(known) is None
    one = Agenda(changed, agenda(left=NOW, right=NOW).sightings)
    assert [seen.camera for seen in one.usable()] == ["left"], "what a camera of another size saw is of no use"


def test_what_failed_is_not_tried_again_before_something_else_is_seen() -> None:
    book = agenda(left=NOW - 5 * S, right=NOW - 5 * S)
    book.note_failure(book.unrefined(None, NOW))
    assert book.unrefined(None, NOW) == ()
    book.sightings["left"] = message(sighting("left", NOW - 2 * S), NOW - 2 * S)
    assert book.unrefined(None, NOW) == ("left", "right")


def test_a_run_is_collected_when_all_have_answered_or_too_much_time_has_passed() -> None:
    run = CalibrationRun(
        id=7, state=RunState.COLLECTING, stamp_ns=NOW, started_ns=NOW, by="olga", cameras=("left", "right")
    )
    book = agenda(left=NOW, right=NOW)
    assert book.answered(run) == ()
    book.sightings["left"] = message(sighting("left", NOW), NOW, request=7)
    book.sightings["right"] = message(sighting("right", NOW), NOW, request=6)
    assert book.answered(run) == ("left",)
    assert not book.is_collected(run, NOW + 14 * S)
    assert book.is_collected(run, NOW + 16 * S)
    assert book.why_silent(run) == "right did not answer (its process has never reported)"
    book.sightings["right"] = message(sighting("right", NOW), NOW, request=7)
    assert book.is_collected(run, NOW)
