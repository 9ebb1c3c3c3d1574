"""The bar of Client.watch."""

import sys
from typing import Any, Optional

from .statuses import Study


def _text(study: Study) -> str:
    """ "running, 2 render, 1 train": the state, and how many jobs of each kind run."""
    return ", ".join([study.state, *(f"{jobs} {kind}" for kind, jobs in study.jobs("leased").items())])


class Progress:
    """A bar of tqdm where that is installed (in notebooks a widget, if they have any), else a line that is written anew."""

    def __init__(self) -> None:
        self._bar: Optional[Any] = None
        self._width = 0

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: Any) -> None:
        if self._bar is not None:
            self._bar.close()
        elif self._width:
            print(file=sys.stderr)

    def show(self, study: Study) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            line = f"{study.name}: {study.pairs_done}/{study.pairs_wanted} pairs, {_text(study)}"
            self._width = max(self._width, len(line))
            print("\r" + line.ljust(self._width), end="", file=sys.stderr, flush=True)
            return
        if self._bar is None:  # Pairs that are there already say nothing about the rate.
            self._bar = tqdm(desc=study.name, total=study.pairs_wanted, initial=study.pairs_done, unit="pair")
        self._bar.n, self._bar.total = study.pairs_done, study.pairs_wanted
        self._bar.set_postfix_str(_text(study))
