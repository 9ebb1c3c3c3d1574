"""The messages of proto/parallax/v1, made at run time from descriptors: no generated code, which would need one version of
protobuf. Built packages have the descriptors as a file, written by `_messages.py FILE`; in a clone protoc makes them."""

import importlib.util
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any, Tuple

_BUILT = Path(__file__).with_name("service.descriptors")
_PROTO = Path(__file__).absolute().parents[4] / "proto"


def compiled() -> bytes:
    """The descriptors of all messages and services, by `protoc` or grpcio-tools. Errors: OSError without a clone's proto/ or
    without a compiler; it says what to do."""
    sources = sorted(map(str, (_PROTO / "parallax" / "v1").glob("*.proto")))
    if not sources:
        raise OSError(f"{_PROTO}: no such folder; the client needs a package that was built from a clone of Parallax")
    program = shutil.which("protoc")
    if program:
        command = [program]
    elif importlib.util.find_spec("grpc_tools"):
        command = [sys.executable, "-m", "grpc_tools.protoc"]
    else:
        raise OSError("no protoc on PATH; `apt install protobuf-compiler` or `pip install grpcio-tools` gives one")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "descriptors"
        subprocess.run([*command, f"-I{_PROTO}", f"--descriptor_set_out={out}", "--include_imports", *sources], check=True)
        return out.read_bytes()


@lru_cache(maxsize=None)
def _pool() -> Any:
    from google.protobuf import descriptor_pb2, descriptor_pool
    files = descriptor_pb2.FileDescriptorSet.FromString(_BUILT.read_bytes() if _BUILT.is_file() else compiled())
    pool = descriptor_pool.DescriptorPool()  # Not the process's: another package may have messages of these names.
    for file in files.file:
        pool.AddSerializedFile(file.SerializeToString())
    return pool


@lru_cache(maxsize=None)
def method_of(name: str) -> Tuple[str, Any, Any]:
    """Path of an RPC, and the classes of its request and reply: of "GetStudy", or of "Artifacts.Get" of another service than
    Coordinator."""
    from google.protobuf import message_factory
    pool = _pool()
    service, _, method = name.rpartition(".")
    service = f"parallax.v1.{service or 'Coordinator'}"
    found = pool.FindServiceByName(service).methods_by_name[method]
    if hasattr(message_factory, "GetMessageClass"):
        make = message_factory.GetMessageClass
    else:  # Before protobuf 4.22.
        make = message_factory.MessageFactory(pool).GetPrototype
    return f"/{service}/{method}", make(found.input_type), make(found.output_type)


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(compiled())
