"""A farm on this machine for as long as this process needs it: the program `parallax stream STUDY --workers N`."""

import json
import os
import subprocess
import tempfile
import weakref
from typing import IO, Any, Optional, Union

from .client import StudySource, error_of, file_of, program_for
from .errors import ParallaxError

_END_S = 30  # Workers hand back what they do, and end, within this.


class LocalFarm:
    """Makes the pairs of an endless study with workers of its own, until close(), the end of this object, or that of the process
    that made it, whatever ends it.

    study    an endless study, as of Client.submit
    workers  processes; each uses all cores
    out      folder of its database and pairs, from which the same study goes on; None: the study's name and -stream

    name, address  for PairStream, also in other processes of this machine
    Errors: ParallaxError.
    """

    def __init__(self, study: StudySource, workers: int = 2, out: Union[None, str, "os.PathLike[str]"] = None):
        self._log: IO[bytes] = tempfile.TemporaryFile()
        with file_of(study) as file:
            command = [program_for("stream"), "stream", file, "--json", "--workers", str(workers), "--pid", str(os.getpid())]
            # A session of its own: Ctrl-C is for the training, which may go on.
            self._process = subprocess.Popen(command + (["--out", os.fspath(out)] if out is not None else []),
                                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self._log,
                                             start_new_session=True)
            self.close = weakref.finalize(self, _end, self._process, self._log, os.getpid())
            with self._process.stdout as stdout:  # type: ignore[union-attr]
                line = stdout.readline()
        if not line:
            self._process.wait()
            self.check()
        said = json.loads(line)
        self.name, self.address, self.out = str(said["streams"][0]["name"]), str(said["address"]), str(said["out"])

    def check(self) -> None:
        """Raises the error with which the farm has ended, if it has."""
        if not self.close.alive or self._process.poll() is None:
            return
        self._log.seek(0)
        text = error_of(self._log.read().decode("utf-8", "replace"))
        code = self._process.returncode
        raise ParallaxError(text or f"the local farm ended with status {code}", code if code > 0 else ParallaxError.FAILED)


def _end(process: "subprocess.Popen[Any]", log: IO[bytes], owner: int) -> None:
    log.close()
    if os.getpid() != owner:  # A fork of the process that has the farm.
        return
    process.terminate()
    try:
        process.wait(_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
