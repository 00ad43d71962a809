"""How long work reports to whoever watches: the same event from heuristics and exact methods."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from cutgap.instances.scene import Scene

SceneMaker = Callable[[], Scene]


@dataclass(frozen=True, slots=True)
class Progress:
    """State of a run: best value and proved bound so far (objective's unit), seconds since its start.

    ``scene`` makes a picture of what the run has before it. It may only be called while the watch is: so a run
    pays nothing for pictures that nobody asks for.
    """

    seconds: float
    value: float | None = None
    lower_bound: float | None = None
    message: str = ""
    scene: SceneMaker | None = None

    def seen_as(self, unit: Callable[[float], float], nodes: Sequence[int] | None = None) -> "Progress":
        """Return the event with figures in another unit and, in scenes, ``nodes[v]`` in place of each v."""
        make = self.scene

        def seen() -> Scene:
            assert make is not None
            scene = make().with_bounds(unit)
            return scene if nodes is None else scene.with_nodes(nodes)

        return replace(
            self,
            value=None if self.value is None else unit(self.value),
            lower_bound=None if self.lower_bound is None else unit(self.lower_bound),
            scene=None if make is None else seen,
        )


Watch = Callable[[Progress], None]


def nobody(progress: Progress) -> None:
    """Watch nothing: the default."""
