"""A client of Parallax's coordinator, for notebooks and scripts.

    from parallax_data import Client
    client = Client("farm.example.org:7070", tls="farm-tls/submitter-ada")
    study = client.submit("my-study.yaml", pairs=200)
    client.watch(study)                        # a bar, until it ends
    client.fetch(study, "out/my-study")        # for ParallaxDataset
    client.table(study)                        # a DataFrame, with pandas

What reads or steers studies goes by gRPC and needs only grpcio and protobuf. What resolves a study's file, writes a dataset or
computes a table (`submit`, `plan`, `fetch`, `table`) is done by the program `parallax`: its rules are written once, in C++. The
program is also asked why a connection fails, because it tells expired certificates from wrong ones.
"""

import contextlib
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Union

from ._connection import Connection
from ._progress import Progress
from .errors import ParallaxError
from .statuses import (Attempt, Fetched, Forgotten, Job, Study, Submitted, Waiting, Worker, of_json, of_message, scene_of,
                       study_of)

StudyName = Union[int, str, Study, Submitted]  # An id, a name (the newest study of that name), or what a method returned.
StudySource = Union[str, "os.PathLike[str]", Mapping[str, Any]]
Option = Union[None, bool, int, float, str, "os.PathLike[str]", Sequence[str]]

DEFAULT_ADDRESS = "127.0.0.1:7070"
_TEXT = ".parallax-study-"  # Begins the name of the file of a study that was given as a text.
_PATIENCE_S = 60  # A coordinator that restarts is back within this.


def _program() -> Optional[str]:
    """The program `parallax`: that of the wheel, which has it beside this package, or else of PATH."""
    beside = Path(__file__).absolute().parents[1] / "parallax_stereo" / "bin" / "parallax"
    return shutil.which(str(beside)) or shutil.which("parallax")


def program_for(command: str) -> str:
    """The program that does `command`. Errors: ParallaxError without one."""
    program = _program()
    if program is None:
        raise ParallaxError(f"`{command}` needs the program parallax: `pip install parallax-stereo`, or put it on PATH",
                            ParallaxError.USAGE)
    return program


def error_of(printed: str) -> str:
    """The text of the error in what the program printed to standard error."""
    return re.split(r"^error: ", printed, maxsplit=1, flags=re.MULTILINE)[-1].strip()


def _flags(options: Mapping[str, Option]) -> List[str]:
    """Options as the command line has them: max_running=3, again=True."""
    flags: List[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        flags.append("--" + name.replace("_", "-"))
        if value is not True:
            flags.append(",".join(value) if isinstance(value, (list, tuple)) else str(value))
    return flags


def _id_or_name(study: StudyName) -> str:
    return str(study.study_id if isinstance(study, (Study, Submitted)) else study)


@contextlib.contextmanager
def file_of(study: StudySource) -> Iterator[str]:
    """The file of a study, or its built-in name. A text becomes a file of the working folder, from where its paths count."""
    if isinstance(study, Mapping):
        study = json.dumps(study) + "\n"
    if not isinstance(study, str) or "\n" not in study:
        yield os.fspath(study)
        return
    with tempfile.NamedTemporaryFile("w", prefix=_TEXT, suffix=".yaml", dir=".") as file:
        file.write(study)
        file.flush()
        yield os.path.basename(file.name)


def _table_rows(table: Mapping[str, Any]) -> List[Dict[str, Any]]:
    """A row for each variant, trainer, benchmark and metric, with its comparison with the baseline where there is one."""
    compared = {(one["variant"], one["trainer"], one["benchmark"], one["metric"]): one for one in table["comparisons"]}
    rows = []
    for row in table["rows"]:
        for benchmark, cell in row["benchmarks"].items():
            for figure in [cell, *cell["others"]]:
                one = compared.get((row["variant"], row["trainer"], benchmark, figure["metric"]), {})
                rows.append({
                    "variant": row["variant"], "trainer": row["trainer"], "seeds": row["seeds"], "benchmark": benchmark,
                    **{name: figure[name] for name in ("metric", "value", "low", "high", "pairs")},
                    **{name: one.get(name) for name in ("baseline", "difference", "verdict", "more_seeds")}})
    return rows


class Client:
    """A coordinator, as the command `parallax` sees it. Thread-safe.

    address   "HOST:PORT" or "unix:/path"; None: $PARALLAX_COORDINATOR, or 127.0.0.1:7070
    tls       folder with a certificate, as `coordinator init` makes it; None: $PARALLAX_TLS, or none
    insecure  reach another machine without encryption

    Nothing is connected before the first call. Errors: ParallaxError, with the text and exit code of `parallax`. A method's
    `**options` are those of the command of its name, as `parallax COMMAND --help` lists them: `--max-running 3` is
    `max_running=3`, `--again` is `again=True`.
    """

    def __init__(self, address: Optional[str] = None, tls: Union[None, str, "os.PathLike[str]"] = None, insecure: bool = False):
        self.address = address or os.environ.get("PARALLAX_COORDINATOR") or DEFAULT_ADDRESS
        self.tls = os.fspath(tls) if tls is not None else os.environ.get("PARALLAX_TLS", "")
        self.insecure = insecure
        self._lock = threading.Lock()
        self._connection: Optional[Connection] = None  # Guarded by _lock.

    def __repr__(self) -> str:
        return f"Client({self.address!r}{f', tls={self.tls!r}' if self.tls else ''})"

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection. The next call makes a new one."""
        with self._lock:
            if self._connection is not None:
                self._connection.close()
            self._connection = None

    # ---- By gRPC

    @property
    def _calls(self) -> Connection:
        with self._lock:
            if self._connection is None:
                self._connection = Connection(self.address, self.tls, self.insecure, self._explained)
            return self._connection

    def studies(self, limit: int = 20) -> List[Study]:
        """The newest studies; their problems are shown by `status` only."""
        return [study_of(one) for one in self._calls.studies(limit)]

    def status(self, study: StudyName) -> Study:
        """A study with its variants and problems."""
        return study_of(self._calls.find(_id_or_name(study)))

    def follow(self, study: StudyName, poll_s: float = 0.5) -> Iterator[Study]:
        """The study now and whenever it has changed, until it has ended. A coordinator that does not answer is waited for, for
        a minute."""
        status = self.status(study)
        yield status
        heard_s = time.monotonic()
        while not status.finished:
            time.sleep(poll_s)
            try:
                now = study_of(self._calls.call("GetStudy", study_id=status.study_id))
            except ParallaxError as error:
                if error.code != ParallaxError.UNREACHABLE or time.monotonic() - heard_s > _PATIENCE_S:
                    raise
                continue
            heard_s = time.monotonic()
            if now != status:
                yield now
            status = now

    def watch(self, study: StudyName, poll_s: float = 0.5) -> Study:
        """Shows a bar (of tqdm where that is installed, else a line that is written anew) until the study has ended. Returns
        its last status: look at its `state`, because a failed study is no error here. Interrupting ends the watching, not the
        study."""
        with Progress() as progress:
            for status in self.follow(study, poll_s):
                progress.show(status)
        return status

    def jobs(self, study: StudyName, state: str = "", limit: Optional[int] = None) -> List[Job]:
        """Jobs of a study, in one state ("failed", "ready"...) or in all, at most `limit` (None: all of them)."""
        calls = self._calls
        messages = calls.jobs(calls.find(_id_or_name(study)).study_id, state, limit)
        return [of_message(Job, one, state=one.state.lower(), scene=scene_of(one), rigs=list(one.rigs), figures=dict(one.figures))
                for one in messages]

    def attempts(self, job_id: int) -> List[Attempt]:
        """The attempts of a job, the newest first, with the last lines of those that failed or run."""
        attempts = self._calls.call("ListAttempts", job_id=job_id).attempts
        return [of_message(Attempt, one, fence=str(one.attempt.fence)) for one in attempts]

    def logs(self, job_id: int) -> str:
        """The last lines of a job's newest attempt that has some; "" without any."""
        return next((attempt.log_tail for attempt in self.attempts(job_id) if attempt.log_tail), "")

    def workers(self) -> List[Worker]:
        """The workers that the coordinator knows."""
        return [of_message(Worker, one, state=one.state.lower(), kinds=list(one.kinds))
                for one in self._calls.call("ListWorkers").workers]

    def pause(self, study: StudyName, reason: str = "") -> Study:
        """Starts no more jobs of the study; running jobs finish. `reason`, here and below, is kept in the audit trail."""
        return self._steer("Pause", study, reason)

    def resume(self, study: StudyName, reason: str = "") -> Study:
        """Goes on with a paused study."""
        return self._steer("Resume", study, reason)

    def cancel(self, study: StudyName, reason: str = "") -> Study:
        """Ends the study for good; finished pairs are kept."""
        return self._steer("Cancel", study, reason)

    def retry(self, study: StudyName) -> int:
        """Tries failed and quarantined jobs of the study again; returns their number."""
        return int(self._calls.call("Retry", study_id=self._calls.find(_id_or_name(study)).study_id).jobs)

    def forget(self, study: StudyName, reason: str = "") -> Forgotten:
        """Removes an ended study with the pairs, networks and scores that no other study uses. It does not ask."""
        study_id = self._calls.find(_id_or_name(study)).study_id
        return of_message(Forgotten, self._calls.call("Forget", study_id=study_id, reason=reason))

    def call(self, method: str, **fields: Any) -> Any:
        """The reply, a message, to any unary RPC of proto/parallax/v1 with these fields of its request: "GetInfo", or
        "Streams.List" of another service than Coordinator."""
        return self._calls.call(method, **fields)

    def file(self, path: str) -> bytes:
        """A file of the coordinator's store, by the path that its replies have."""
        return self._calls.file(path)

    def _steer(self, method: str, study: StudyName, reason: str) -> Study:
        before = study_of(self._calls.find(_id_or_name(study)))
        if method == "Resume" and before.state == "cancelled":
            raise ParallaxError(f"study {before.study_id} is cancelled: submit it again instead", ParallaxError.USAGE)
        return study_of(self._calls.call(method, study_id=before.study_id, reason=reason))

    # ---- By the program

    def submit(self, study: StudySource, **options: Option) -> Submitted:
        """Gives a study to the coordinator. `study` is a file, the name of a built-in study, the text of a file (of more than
        one line), or what a file would say as a dict. The same study again is not made twice."""
        with file_of(study) as file:
            submitted = of_json(Submitted, self._run("submit", file, options))
        waiting = [Waiting(**one) for one in submitted.unservable]  # type: ignore[arg-type]
        return Submitted(**{**vars(submitted), "unservable": waiting})

    def plan(self, study: StudySource, **options: Option) -> Dict[str, Any]:
        """What a study would take, as `parallax plan --json` says it: "variants", "total", "jobs", "core_hours",
        "wall_clock_s" on `cores=`, "disk_bytes", "power", "missing"... Needs no coordinator."""
        with file_of(study) as file:
            return dict(self._run("plan", file, options))

    def fetch(self, study: StudyName, out: Union[str, "os.PathLike[str]"], **options: Option) -> Fetched:
        """Brings the study's finished pairs, networks and scores into the folder `out`, for ParallaxDataset; again while it
        runs, only what is new."""
        return of_json(Fetched, self._run("fetch", _id_or_name(study), {"out": out, **options}))

    def open_stream(self, study: StudySource, **options: Option) -> str:
        """Begins the stream of an endless study, or finds it; returns its name, for parallax_data.streams."""
        with file_of(study) as file:
            return str(self._run("stream", file, options)["streams"][0]["name"])

    def table(self, study: StudyName, **options: Option) -> Any:
        """The study's scores, also of a folder: a row for each variant, trainer, benchmark and metric, with `value` and its
        95 % interval from `low` to `high`; and where it is compared, `difference` from `baseline` and the `verdict`. A pandas
        DataFrame where pandas is installed, else a list of dicts."""
        rows = _table_rows(self._run("table", _id_or_name(study), options))
        try:
            import pandas
        except ImportError:
            return rows
        return pandas.DataFrame(rows)

    def _run(self, command: str, argument: str, options: Mapping[str, Option]) -> Any:
        arguments = [program_for(command), command, *([argument] if argument else []), "--json",
                     *_flags({**options, "insecure": self.insecure})]
        done = subprocess.run(arguments, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace",
                              env={**os.environ, "PARALLAX_COORDINATOR": self.address, "PARALLAX_TLS": self.tls})
        out, errors = done.stdout, done.stderr
        if argument.startswith(_TEXT):
            out, errors = (text.replace(argument, "<study>") for text in (out, errors))
        if done.returncode != 0:
            raise ParallaxError(error_of(errors), done.returncode)
        return json.loads(out)

    def _explained(self, error: ParallaxError) -> ParallaxError:
        if _program() is not None:
            try:
                self._run("status", "", {"limit": 1})
            except ParallaxError as told:
                return told
        return error
