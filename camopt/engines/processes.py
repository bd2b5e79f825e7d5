"""Processes of this machine: for work that is mostly Python."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from camopt.engines import Item, Result


@dataclass(frozen=True)
class Processes:
    """A number of processes, each of which works on one item at a time; they are as many as there are items."""

    count: int

    def in_order(
        self, work: Callable[[Sequence[Item]], Result], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[Result]:
        """What work gives for each item, as ``Engine`` says."""
        from joblib import Parallel, delayed

        count = max(1, min(self.count, len(items)))
        parallel = Parallel(n_jobs=count, return_as="generator", batch_size=1)
        yield from parallel(delayed(work)((item,)) for item in items)
