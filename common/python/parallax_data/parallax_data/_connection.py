"""Calls of the coordinator's service by gRPC, as coordinator/client/connection.cc makes them."""

import ipaddress
import os
from pathlib import Path
from typing import Any, Callable, List, Optional

from .errors import ParallaxError

_MOST_BYTES = 64 << 20
# As in common/rpc/endpoint.cc; but a call between two tries fails with the cause of the last one, and a notebook's coordinator
# that is back should answer at once.
_OPTIONS = [
    ("grpc.max_receive_message_length", _MOST_BYTES), ("grpc.max_send_message_length", _MOST_BYTES),
    ("grpc.keepalive_time_ms", 20_000), ("grpc.keepalive_timeout_ms", 10_000), ("grpc.http2.max_pings_without_data", 0),
    ("grpc.initial_reconnect_backoff_ms", 100), ("grpc.min_reconnect_backoff_ms", 2_000),
    ("grpc.max_reconnect_backoff_ms", 200), ("grpc.enable_http_proxy", 0)]
_STUDIES_AT_ONCE = 100
_JOBS_AT_ONCE = 5000
# The exit codes of `parallax` by gRPC's names of codes, as coordinator/client/exit_code.cc has them; the others: FAILED.
_CODES = {**dict.fromkeys(("INVALID_ARGUMENT", "NOT_FOUND", "ALREADY_EXISTS", "FAILED_PRECONDITION", "OUT_OF_RANGE",
                           "UNAUTHENTICATED"), ParallaxError.USAGE),
          **dict.fromkeys(("UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED"), ParallaxError.UNREACHABLE),
          **dict.fromkeys(("PERMISSION_DENIED", "RESOURCE_EXHAUSTED"), ParallaxError.DISK)}
_CAUSES = ("Connection refused", "No such file or directory", "No route to host", "Network is unreachable",
           "Permission denied", "Connection reset")


def _is_of_this_machine(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Connection:
    """Connects at the first call, and again when the connection was lost. `explain` may find better words for the error of
    a failed connection. Thread-safe. Errors: ParallaxError, also of all methods."""

    def __init__(self, address: str, tls: Optional[str], insecure: bool,
                 explain: Callable[[ParallaxError], ParallaxError] = lambda error: error):
        os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # Failed connections are exceptions; gRPC would print them as well.
        try:
            import grpc
            import google.protobuf  # noqa: F401
        except ImportError as error:
            raise ImportError(f"{error}; the client needs it: `pip install grpcio protobuf`, or Debian's python3-grpcio and "
                              "python3-protobuf") from None
        self._address, self._explain, self._errors = address, explain, grpc.RpcError
        is_unix = address.startswith("unix:")
        if tls and insecure:
            raise explain(ParallaxError("--tls and --insecure exclude each other", ParallaxError.USAGE))
        if not (is_unix or tls or insecure or _is_of_this_machine(address.rpartition(":")[0].strip("[]"))):
            raise explain(ParallaxError(
                f"address {address} is not of this machine, and the connection would be neither encrypted nor authenticated; "
                "use a loopback address or a Unix socket, give --tls DIR with a certificate from `coordinator init`, or allow "
                "it with --insecure", ParallaxError.USAGE))
        if tls:  # Also for a socket, which does not use them: a wrong folder is an error everywhere.
            try:
                authority, certificate, key = ((Path(tls) / name).read_bytes() for name in ("ca.crt", "tls.crt", "tls.key"))
            except OSError as error:
                raise explain(ParallaxError(f"{error.filename}: {error.strerror}", ParallaxError.USAGE)) from None
        if tls and not is_unix:
            self._channel = grpc.secure_channel(address, grpc.ssl_channel_credentials(authority, key, certificate), _OPTIONS)
        else:
            self._channel = grpc.insecure_channel(address, _OPTIONS)
        # Over a Unix socket nothing is lost on the way, but the machine may be busy.
        self._timeout_s = 120 if is_unix else 20

    def close(self) -> None:
        self._channel.close()

    def call(self, method: str, **values: Any) -> Any:
        """The reply to a unary RPC ("GetStudy", "Streams.Next") with these fields of its request."""
        from . import _messages  # Needs protobuf.
        path, request, reply = _messages.method_of(method)
        do = self._channel.unary_unary(path, request.SerializeToString, reply.FromString)
        try:
            return do(request(**values), timeout=self._timeout_s + values.get("wait_s", 0))
        except self._errors as error:
            raise self._worded(error) from None

    def file(self, path: str) -> bytes:
        """A file of the coordinator's store."""
        from . import _messages
        method, request, chunk = _messages.method_of("Artifacts.Get")
        do = self._channel.unary_stream(method, request.SerializeToString, chunk.FromString)
        try:
            return b"".join(one.data for one in do(request(path=path), timeout=self._timeout_s))
        except self._errors as error:
            raise self._worded(error) from None

    def _worded(self, error: Any) -> ParallaxError:
        name, details = error.code().name, error.details() or ""
        if name == "UNAVAILABLE":
            cause = next((cause for cause in _CAUSES if cause in details), details.partition("\n")[0])
            cause = "unknown host" if "DNS resolution failed" in details else cause
            details = (f"no coordinator at {self._address}: {cause}; start one with `coordinator serve --db FILE --store DIR "
                       f"--listen {self._address}`, or name another with --coordinator HOST:PORT")
        elif name == "DEADLINE_EXCEEDED":
            shown = f"{self._timeout_s // 60} min" if self._timeout_s >= 60 else f"{self._timeout_s} s"
            details = f"the coordinator at {self._address} did not answer within {shown}"
        elif name == "CANCELLED":
            details = f"the coordinator at {self._address} ended before it answered"
        elif name == "UNIMPLEMENTED":
            details = f"what answers at {self._address} is not a Parallax coordinator of this version"
        worded = ParallaxError(details, _CODES.get(name, ParallaxError.FAILED), name)
        return self._explain(worded) if name == "UNAVAILABLE" else worded

    def studies(self, limit: int) -> List[Any]:
        """StudyStatus of the newest studies."""
        found: List[Any] = []
        while len(found) < limit:
            page = self._studies_before(found[-1].study_id if found else 0, limit - len(found))
            if not page:
                break
            found += page
        return found

    def _studies_before(self, before: int, limit: int) -> List[Any]:
        page = list(self.call("ListStudies", before=before, limit=limit).studies)
        return [] if before and page and page[0].study_id >= before else page  # An earlier coordinator begins anew.

    def find(self, id_or_name: str) -> Any:
        """StudyStatus of the study with this id, or the newest one of this name."""
        if id_or_name.isascii() and id_or_name.isdigit() and int(id_or_name) < 2**63:
            try:
                return self.call("GetStudy", study_id=int(id_or_name))
            except ParallaxError as error:
                if error.status != "NOT_FOUND":
                    raise
        known, page = "", self._studies_before(0, _STUDIES_AT_ONCE)
        if page:
            known = ", ".join(f"{one.study_id} ({one.name})" for one in page[:5]) + ("..." if len(page) > 5 else "")
        while page:
            for one in page:
                if one.name == id_or_name:
                    return self.call("GetStudy", study_id=one.study_id)  # Only this one has the whole status.
            page = self._studies_before(page[-1].study_id, _STUDIES_AT_ONCE)
        raise ParallaxError(
            f"no study '{id_or_name}' at {self._address}" + (f"; there are {known}" if known else "; nothing has been submitted there"),
            ParallaxError.USAGE)

    def jobs(self, study_id: int, state: str, limit: Optional[int]) -> List[Any]:
        """JobStatus of the study's jobs, at most `limit`."""
        found: List[Any] = []
        while limit is None or len(found) < limit:
            asked = _JOBS_AT_ONCE if limit is None else min(limit - len(found), _JOBS_AT_ONCE)
            last = {"after_job": found[-1].job_id, "after_state": found[-1].state} if found else {}
            page = self.call("ListJobs", study_id=study_id, state=state.upper(), limit=asked, **last)
            if not page.jobs or (found and page.jobs[0].job_id == found[0].job_id):  # An earlier coordinator begins anew.
                break
            found += page.jobs
            if len(page.jobs) < asked and not page.cut:
                break
        return found
