"""`python -m server.openapi` prints the OpenAPI document, with the messages of the live stream among its components.

Nothing is started and no environment is needed: the console's types are generated from this.
"""

import json
import sys
from typing import Any

from pydantic.json_schema import models_json_schema

from server.app import assemble
from server.views.live import LiveChanges, LiveSnapshot

_REF = "#/components/schemas/{model}"


def document() -> dict[str, Any]:
    """The OpenAPI document."""
    app = assemble()
    described = app.openapi()
    _, live = models_json_schema([(LiveSnapshot, "validation"), (LiveChanges, "validation")], ref_template=_REF)
    schemas: dict[str, Any] = described["components"]["schemas"]
    for name, schema in live["$defs"].items():
        schemas.setdefault(name, schema)
    described["components"]["schemas"] = dict(sorted(schemas.items()))
    return described


def main() -> None:
    """Prints it."""
    json.dump(document(), sys.stdout, indent=2, ensure_ascii=False, sort_keys=False)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
