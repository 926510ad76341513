"""What has been sent to viser, by name: a node is sent again only when its content changed, and removed when it is no longer
drawn. viser itself sends whatever it is given, and keeps all of it for those who connect later."""

from collections.abc import Callable, Hashable, Iterable

import viser

Make = Callable[[viser.SceneApi, str], viser.SceneNodeHandle]


class Canvas:
    """Nodes by name (a path, as viser has them). `sent` counts what was made, for tests of thrift."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._nodes: dict[str, tuple[Hashable, viser.SceneNodeHandle]] = {}
        self.sent = 0

    def draw(self, name: str, content: Hashable, make: Make) -> viser.SceneNodeHandle:
        """The node called `name`, made anew by `make` unless `content` is what it was made of the last time."""
        known = self._nodes.get(name)
        if known is not None and known[0] == content:
            return known[1]
        handle = make(self._scene, name)
        self._nodes[name] = (content, handle)
        self.sent += 1
        return handle

    def erase(self, name: str) -> None:
        """Removes the node and those below it; nothing happens when there is none."""
        for child in [other for other in self._nodes if other.startswith(f"{name}/")]:
            del self._nodes[child]
        known = self._nodes.pop(name, None)
        if known is not None:
            known[1].remove()

    def keep_only(self, folder: str, names: Iterable[str]) -> None:
        """Removes the nodes directly in `folder` that are not in `names`."""
        prefix, wanted = f"{folder}/", set(names)
        present = {name.removeprefix(prefix).split("/")[0] for name in self._nodes if name.startswith(prefix)}
        for name in present - wanted:
            self.erase(prefix + name)

    @property
    def names(self) -> set[str]:
        return set(self._nodes)
