"""`./lilliput detect IMAGE...`: the AprilTags in pictures."""

import argparse
import sys
from typing import Any

from launcher.output import Result, print_result
from localization.images import ImageTag, UnreadableImageError, detect_image


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("images", nargs="+", metavar="IMAGE")
    parser.add_argument("--json", action="store_true", help="print one JSON object, the tags under figures.images")


def run(arguments: argparse.Namespace) -> int:
    images: dict[str, list[dict[str, Any]]] = {}
    unreadable = 0
    names: list[str] = arguments.images  # kept as they were typed: a Path would turn ./a.png into a.png
    for name in names:
        try:
            images[name] = [_described(tag) for tag in detect_image(name)]
        except UnreadableImageError as error:
            unreadable += 1
            print(f"lilliput: {error}", file=sys.stderr)
    figures = {"images": images, "tags": sum(map(len, images.values())), "unreadable": unreadable}
    if arguments.json:
        print_result(Result("detect", figures), as_json=True)
    else:
        for name, tags in images.items():
            print(f"{name}: {len(tags)} {'tag' if len(tags) == 1 else 'tags'}")
            for tag in tags:
                corners = "  ".join(f"({x:.2f}, {y:.2f})" for x, y in tag["corners"])
                print(f"  {tag['family']} {tag['id']:>3}  margin {tag['decision_margin']:5.1f}  corners {corners}")
    return 1 if unreadable else 0


def _described(tag: ImageTag) -> dict[str, Any]:
    return {
        "family": tag.family,
        "id": tag.id,
        "corners": [list(corner) for corner in tag.corners],
        "decision_margin": tag.decision_margin,
    }
