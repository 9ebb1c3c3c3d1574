"""The client's error."""


class ParallaxError(Exception):
    """A command that failed. Its text is what `parallax` prints behind "error:".

    code  the exit code of `parallax`: FAILED (the work failed), USAGE (wrong options, files, names or ids), UNREACHABLE (no
          coordinator answers), DISK (disk full, read-only, or permission denied)
    status  gRPC's name of the error, "NOT_FOUND", where the coordinator gave it; else ""
    """

    FAILED, USAGE, UNREACHABLE, DISK = 1, 2, 3, 4

    def __init__(self, message: str, code: int, status: str = ""):
        super().__init__(message)
        self.code, self.status = code, status
