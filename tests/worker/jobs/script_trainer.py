"""A trainer for tests: its network is a chain of hashes over data, seed and steps, so that whoever skips or repeats a
step, or sees other pairs, ends with another one. What goes wrong says $SCRIPT_TRAINER: a word and a step."""
import argparse
import hashlib
import json
import os
import pathlib
import signal
import struct
import sys
import time


def data_hash(folders):
    digest = hashlib.sha256()
    for folder in folders:
        path, weight = folder.rsplit("=", 1)
        digest.update(weight.encode())
        for line in (pathlib.Path(path) / "index.jsonl").read_text().splitlines():
            frame = json.loads(line)
            for name, expected in sorted(frame["files"].items()):
                content = (pathlib.Path(path) / frame["path"] / name).read_bytes()
                assert hashlib.sha256(content).hexdigest() == expected, frame["path"] + "/" + name
                digest.update(content)
    return digest.hexdigest()


def misbehave(word, step):
    if word == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if word == "nan":
        print(json.dumps({"step": step, "loss": float("nan")}), flush=True)
        time.sleep(30)
    if word == "memory":
        sys.exit("torch.cuda.OutOfMemoryError: CUDA out of memory. Tried to allocate 2 GiB")
    if word == "fail":
        print("".join(f"line {i}\n" for i in range(300)), end="")
        sys.exit("no such luck")
    if word == "usage":
        print("pictures are smaller than the crop", flush=True)
        sys.exit(2)
    if word == "lazy":
        sys.exit(0)


def write_half(path, step):
    """Begins a checkpoint in place, and is at it until it is ended."""
    with open(path, "w") as file:
        file.write(f"[{step}, ")
        print(json.dumps({"step": step, "loss": 1 / step}), flush=True)
        while True:
            file.write(" ")
            file.flush()
            time.sleep(0.02)


def train(args):
    word, _, at = os.environ.get("SCRIPT_TRAINER", "").partition(" ")
    pause = float(os.environ.get("SCRIPT_PAUSE", "0"))
    if word != "half":  # It ends by itself, and is never at a checkpoint then.
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(5))
    start = pathlib.Path(args.start).read_text() if args.start else ""
    state, first = f"{args.seed} {args.crop} {args.batch} {start}{data_hash(args.data)}", 0
    if args.resume:
        first, state = json.loads(pathlib.Path(args.resume).read_text())
        print("resumed from", first)
    out = pathlib.Path(args.out)
    for step in range(first + 1, args.steps + 1):
        state = hashlib.sha256(f"{state} {step}".encode()).hexdigest()
        if word == "half" and step == int(at):
            write_half(out / f"net-{step}.json", step)
        if word and step == int(at):
            misbehave(word, step)
        print(json.dumps({"step": step, "loss": 1 / step, "epe_px": 2 / step}), flush=True)
        if step % args.every == 0 and step < args.steps:
            new = out / "new"
            new.write_text(json.dumps([step, state]))
            new.rename(out / f"net-{step}.json")
        time.sleep(pause)
    (out / "last.json").write_text(json.dumps([args.steps, state]))


def predict(args):
    """The same disparity everywhere: that of the network's first byte, and more for one look."""
    value = int(json.loads(pathlib.Path(args.checkpoint).read_text())[1][:2], 16) / 16 + (args.looks == 1)
    for line in pathlib.Path(args.list).read_text().splitlines():
        left, _, output = line.split()
        width, height = struct.unpack(">II", pathlib.Path(left).read_bytes()[16:24])
        with open(output, "wb") as file:
            file.write(f"Pf\n{width} {height}\n-1\n".encode())
            file.write(struct.pack("<f", value) * (width * height))


parser = argparse.ArgumentParser()
commands = parser.add_subparsers(dest="command", required=True)
sub = commands.add_parser("train")
sub.add_argument("--data", action="append")
sub.add_argument("--out")
sub.add_argument("--seed", type=int)
sub.add_argument("--steps", type=int)
sub.add_argument("--every", type=int)
sub.add_argument("--resume")
sub.add_argument("--crop")
sub.add_argument("--batch")
sub.add_argument("--start")
sub = commands.add_parser("predict")
sub.add_argument("--checkpoint")
sub.add_argument("--list")
sub.add_argument("--looks", type=int)
arguments = parser.parse_args()
train(arguments) if arguments.command == "train" else predict(arguments)
