"""What a batch runs on, and how its scenes are divided."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from holdfast.base.arrays import checked_number, checked_whole
from holdfast.base.values import Value

if TYPE_CHECKING:
    from distributed import Client

MOST_IN_SHARD = 1_000_000


@dataclass(frozen=True, eq=False, repr=False)
class Resources(Value):
    """What a batch runs on, and how its scenes are divided.

    - ``megabytes`` [MB]: the memory beyond which a scene is given up.
    - ``scheduler``: the address of a Dask scheduler, or a ``distributed.Client``. The processes are then on its
      workers; by default they are on this machine.
    - ``shard``: "i/n" does each n-th shard from number i on, for arrays of jobs that share a folder; all by default.
    - ``shard_size``: how many scenes one file of a table holds.

    Raises SceneError for a number out of range.
    """

    megabytes: float = 4000.0
    scheduler: str | Client | None = None
    shard: str | None = None
    shard_size: int = 100

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "megabytes", checked_number(self.megabytes, "Resources: megabytes", above=0))
        set_(self, "shard_size", checked_whole(self.shard_size, "Resources: shard_size", 1, MOST_IN_SHARD))
