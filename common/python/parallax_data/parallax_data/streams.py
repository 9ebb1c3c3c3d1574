"""Pairs of an endless study as the farm makes them (`parallax stream`).

    from parallax_data import stream
    for pair in stream("endless.yaml", max_disparity=192):       # or the name of a stream that is open
        train(pair.left, pair.right, pair.disparity, pair.valid)  # never ends, and no pair comes twice
    stream("endless.yaml", workers=2)                             # without a coordinator: this machine is the farm

A pair is acknowledged when the loop asks for more; then the farm may forget it. A consumer that was killed goes on behind what it
had acknowledged: each pair comes at least once. With `state_dict` in a checkpoint it goes on exactly where the checkpoint is.
"""

import logging
import os
import shutil
import tempfile
import threading
import time
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, Callable, Deque, Dict, Iterator, List, Optional, Sequence, Tuple, TypeVar

from . import frame_maps
from .client import Client
from .dataset import Frame, Pair, check_maps, read_pair
from .errors import ParallaxError
from .local_farm import LocalFarm

_WAIT_S = 10.0     # One call of Next waits so long on the coordinator.
_SAY_AFTER_S = 30  # A consumer that waits longer hears why, once for each reason.
_AGAIN_S = 1.0     # Between tries while the coordinator is away.

_log = logging.getLogger(__name__)
_Reply = TypeVar("_Reply")


class PairStream:
    """An endless iterable of pairs.

    name       of a stream that is open, or the file of an endless study, which opens it (needs the program `parallax`)
    address, tls, insecure   as of Client
    consumer   its name: under it the farm keeps what is acknowledged. Consumers of other names get all pairs as well
    rank, ranks  this consumer's part: the parts of `ranks` consumers of one name are disjoint and together complete
    position   where to begin: of state_dict(). None: behind what the consumer has acknowledged
    max_disparity, pictures, maps, transform   as of ParallaxDataset
    ahead      pairs that are read before they are asked for
    lag        pairs that are acknowledged later than they are asked for: as many as whoever iterates keeps in a queue
    patience_s how long a coordinator may be away before the error of its absence ends the iteration
    workers, out  without a coordinator: as of LocalFarm, which ends with close(), this object or this process
    """

    def __init__(self, name: str, address: Optional[str] = None, tls: Optional[str] = None, insecure: bool = False, *,
                 consumer: str = "train", rank: int = 0, ranks: int = 1, position: Optional[int] = None,
                 max_disparity: Optional[float] = None, pictures: str = "color", maps: Sequence[str] = (),
                 transform: Optional[Callable[[Pair], Any]] = None, ahead: int = 16, lag: int = 0, threads: int = 2,
                 patience_s: float = 600, workers: int = 0, out: Optional[str] = None):
        check_maps(pictures, maps)
        if workers > 0 and address:
            raise ValueError("workers=N makes a farm on this machine, and address names another; allowed is one of them")
        self._farm = LocalFarm(name, workers, out) if workers > 0 else None
        self._options: Dict[str, Any] = {"address": address, "tls": tls, "insecure": insecure}
        if self._farm is not None:
            name, self._options["address"] = self._farm.name, self._farm.address
        elif os.path.exists(name):
            name = Client(**self._options).open_stream(name)
        self.name, self.consumer, self.rank, self.ranks = name, consumer, rank, ranks
        self.max_disparity, self.pictures, self.maps, self.transform = max_disparity, pictures, tuple(maps), transform
        self.ahead, self.lag, self.threads, self.patience_s = max(1, ahead), lag, threads, patience_s
        self._position = position  # Behind the last pair that was used; None: the coordinator knows.
        self.waited_s = 0.0        # For pairs, in all.
        self.delivered = 0

    def state_dict(self) -> Dict[str, Optional[int]]:
        """What load_state_dict takes to go on behind the last pair that was used."""
        return {"position": self._position}

    def load_state_dict(self, state: Dict[str, Optional[int]]) -> None:
        self._position = state["position"]

    def close(self) -> None:
        """Ends the farm on this machine, if there is one. The same again goes on."""
        if self._farm is not None:
            self._farm.close()

    def __iter__(self) -> Iterator[Any]:
        reader = _Reader(self)
        used: Deque[Tuple[int, Callable[[], None]]] = deque()
        try:
            while True:
                began = time.monotonic()
                pair, after, drop = reader.next()
                self.waited_s += time.monotonic() - began
                self.delivered += 1
                yield pair if self.transform is None else self.transform(pair)
                used.append((after, drop))
                while len(used) > self.lag:
                    self._position, done = used.popleft()
                    done()
                    reader.acknowledge(self._position)
        finally:
            reader.close()


def stream(name: str, address: Optional[str] = None, **options: Any) -> PairStream:
    """The pairs of a stream; see PairStream."""
    return PairStream(name, address, **options)


class _Reader:
    """Asks for pairs in a thread of its own, and decodes them in others."""

    def __init__(self, owner: PairStream):
        self._owner = owner
        self._client = Client(**owner._options)
        self._lock = threading.Condition()
        self._queue: Deque[Tuple[Future, int, Callable[[], None]]] = deque()
        self._acknowledged = 0
        self._error: Optional[BaseException] = None
        self._closing = False
        self._folder: Optional[str] = None  # Of files that come through the coordinator.
        self._pool = ThreadPoolExecutor(max(1, owner.threads))
        self._thread = threading.Thread(target=self._run, name="parallax stream", daemon=True)
        self._thread.start()

    def next(self) -> Tuple[Pair, int, Callable[[], None]]:
        with self._lock:
            while not self._queue and self._error is None:
                self._lock.wait()
            if not self._queue:
                raise self._error  # type: ignore[misc]
            pair, after, drop = self._queue.popleft()
            self._lock.notify_all()
        return pair.result(), after, drop

    def acknowledge(self, position: int) -> None:
        with self._lock:
            self._acknowledged = max(self._acknowledged, position)

    def close(self) -> None:
        with self._lock:
            self._closing = True
            self._lock.notify_all()
        self._thread.join()
        try:
            self._ask(position=self._acknowledged, wait_s=0.0, limit=1)  # The last acknowledgement.
        except ParallaxError:
            pass  # Its pairs come again.
        self._pool.shutdown()
        self._client.close()
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _ask(self, **values: Any) -> Any:
        owner = self._owner
        return self._client.call("Streams.Next", stream=owner.name, consumer=owner.consumer, rank=owner.rank,
                                 ranks=owner.ranks, acknowledged=self._acknowledged, **values)

    def _run(self) -> None:
        try:
            self._fetch()
        except BaseException as error:  # The consumer's thread raises it.
            with self._lock:
                self._error = error
                self._lock.notify_all()

    def _fetch(self) -> None:
        owner = self._owner
        where: Dict[str, Any] = {"resume": True} if owner._position is None else {"position": owner._position}
        waits_since = time.monotonic()
        said = ""
        while True:
            with self._lock:
                while len(self._queue) >= owner.ahead and not self._closing:
                    self._lock.wait()
                if self._closing:
                    return
                limit = owner.ahead - len(self._queue)
            reply = self._patiently(partial(self._ask, wait_s=min(_WAIT_S, 1.0 + owner.patience_s), limit=limit, **where))
            where = {"position": reply.position}
            if reply.pairs:
                waits_since = time.monotonic()
            elif time.monotonic() - waits_since > _SAY_AFTER_S and reply.waits_for != said:
                said = reply.waits_for
                _log.warning("stream %s waits: %s", owner.name, said)
            positions = [pair.position for pair in reply.pairs[1:]] + [reply.position]
            for pair, after in zip(reply.pairs, positions):
                folder, drop = self._patiently(partial(self._bring, pair, reply.store_uri))
                future = self._pool.submit(self._read, pair, folder)
                with self._lock:
                    self._queue.append((future, after, drop))
                    self._lock.notify_all()

    def _patiently(self, call: Callable[[], _Reply]) -> _Reply:
        """What `call` returns; it is made again while the coordinator is away: one that restarts is back soon."""
        began = time.monotonic()
        while True:
            try:
                return call()
            except ParallaxError as error:
                if self._owner._farm is not None:
                    self._owner._farm.check()
                away = error.code == ParallaxError.UNREACHABLE
                if not away or self._closing or time.monotonic() - began > self._owner.patience_s:
                    raise
            time.sleep(_AGAIN_S)

    def _bring(self, pair: Any, store_uri: str) -> Tuple[Path, Callable[[], None]]:
        """The folder of the pair's files, and what removes it when it is a copy."""
        store = store_uri[len("file://"):] if store_uri.startswith("file://") else ""
        if store and os.path.isdir(os.path.join(store, pair.frame.path)):
            return Path(store, pair.frame.path), lambda: None
        if self._folder is None:
            self._folder = tempfile.mkdtemp(prefix="parallax-stream-")
        folder = Path(self._folder, f"{pair.chunk}-{pair.variant}-{pair.scene}-{pair.frame.rig}-{pair.position}")
        folder.mkdir(exist_ok=True)
        for file in pair.frame.files:
            if self._owner.maps or file.name in _basic_files(self._owner.pictures):
                (folder / file.name).write_bytes(self._client.file(f"{pair.frame.path}/{file.name}"))
        return folder, lambda: shutil.rmtree(folder, ignore_errors=True)

    def _read(self, pair: Any, folder: Path) -> Pair:
        owner = self._owner
        frame = Frame(folder, pair.variant, pair.scene, pair.frame.rig, True, {"chunk": pair.chunk, "position": pair.position})
        return read_pair(frame, owner.pictures, owner.max_disparity, owner.maps)


def _basic_files(pictures: str) -> List[str]:
    """Files of a frame that a pair without further maps is read from."""
    picture = "infrared" if pictures == "infrared" else ""
    return [frame_maps.file_of(picture, "left", ""), frame_maps.file_of(picture, "right", ""),
            frame_maps.file_of("disparity", "left", ""), frame_maps.file_of("masks", "left", ""), "frame.json"]
