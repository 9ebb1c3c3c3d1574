"""Curves of trainings as TensorBoard's event files. Needs neither TensorFlow nor torch.

    python -m parallax_data.tensorboard OUT --log runs        of a study's folder: OUT/training, OUT/curves
    python -m parallax_data.tensorboard progress.jsonl --log runs      what `trainer train` printed
    tensorboard --logdir runs

A run for each training (set/trainer/seed-0) with its loss and errors by step, and for each evaluation of several
checkpoints its figures. Running it again writes the files anew. For wandb and MLflow, log what `read_curves` gives
(deploy/site/docs/recipes/python.md).
"""
import argparse
import csv
import json
import pathlib
import struct

EVENTS = "events.out.tfevents.0.parallax"  # TensorBoard reads files with "tfevents" in their names.


def _crc32c_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


_TABLE = _crc32c_table()


def crc32c(data):
    """CRC-32C (Castagnoli). Source: RFC 3720, appendix B.4."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


def _masked(data):
    crc = crc32c(data)
    return struct.pack("<I", ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF)


def record(data):
    """A TFRecord: length, its checksum, data, its checksum. Source: tensorflow/core/lib/io/record_writer.h."""
    length = struct.pack("<Q", len(data))
    return length + _masked(length) + data + _masked(data)


def _varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def _bytes(field, data):
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def event(step, scalars, wall_s=0.0):
    """An Event (tensorflow/core/util/event.proto) with a Summary of `scalars`, values by tag."""
    values = b"".join(_bytes(1, _bytes(1, tag.encode()) + _varint(2 << 3 | 5) + struct.pack("<f", value))
                      for tag, value in scalars.items())
    return struct.pack("<Bd", 1 << 3 | 1, wall_s) + _varint(2 << 3) + _varint(step) + _bytes(5, values)


def write_events(folder, points):
    """`points`: (step, scalars by tag, seconds since the start). One file in `folder`, replaced as a whole."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    version = struct.pack("<Bd", 1 << 3 | 1, 0.0) + _bytes(3, b"brain.Event:2")
    data = record(version) + b"".join(record(event(step, scalars, seconds)) for step, scalars, seconds in points)
    temporary = folder / ".events.new"
    temporary.write_bytes(data)
    temporary.replace(folder / EVENTS)


def _numbers(row, leave_out):
    numbers = {}
    for name, text in row.items():
        try:
            if name not in leave_out and not isinstance(text, bool):
                numbers[name] = float(text)
        except (TypeError, ValueError):
            pass  # An empty cell, or words.
    return numbers


def _points(rows):
    points = []
    for row in rows:
        numbers = _numbers(row, ("step", "train_s", "elapsed_s", "eta_s", "steps"))
        if numbers and row.get("step") is not None:
            points.append((int(row["step"]), numbers, float(row.get("train_s") or row.get("elapsed_s") or 0)))
    return _in_order(points)


def _in_order(points):
    return sorted(points, key=lambda point: point[0])


def _json_rows(path):
    for line in path.read_text().splitlines():
        try:
            row = json.loads(line)
        except ValueError:
            continue  # A log has other lines too.
        if isinstance(row, dict) and "step" in row and row.get("event", "progress") in ("progress", "step"):
            yield row


def read_curves(path):
    """Points by run, in the order of steps: (step, {name: value}, seconds). Of a study's folder, of a training's folder with
    curve.csv, or of a file of JSON lines."""
    path = pathlib.Path(path)
    if path.is_file():
        return {path.stem: _points(_json_rows(path))}
    curves = {}
    for file in sorted(path.glob("**/curve.csv")):
        run = file.parent.relative_to(path).as_posix()
        run = run[len("training/"):] if run.startswith("training/") else run
        with file.open(newline="") as rows:
            curves[path.name if run == "." else run] = _points(csv.DictReader(rows))
    learning = path / "curves" / "learning_curves.csv"
    if learning.is_file():
        with learning.open(newline="") as rows:
            for row in csv.DictReader(rows):
                run = f"{row['set']}/{row['trainer']}/seed-{row['seed']}"
                tag = f"{row['benchmark']}/{row['metric']}".replace(" ", "_")
                curves.setdefault(run, []).append((int(row["step"]), {tag: float(row["value"])}, 0.0))
    return {run: _in_order(points) for run, points in curves.items()}


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="parallax_data.tensorboard", description=__doc__.split("\n")[0])
    parser.add_argument("source", help="a study's folder, a training's folder, or a file of the trainer's JSON lines")
    parser.add_argument("--log", default="runs", help="folder for TensorBoard's --logdir (default: runs)")
    options = parser.parse_args(arguments)
    if not pathlib.Path(options.source).exists():
        parser.error(f"{options.source}: no such file or folder")
    curves = {run: points for run, points in read_curves(options.source).items() if points}
    if not curves:
        parser.error(f"{options.source}: no curve.csv below it and no progress lines in it")
    for run, points in curves.items():
        write_events(pathlib.Path(options.log) / run, points)
    print(f"{len(curves)} runs in {options.log}; tensorboard --logdir {options.log}")


if __name__ == "__main__":
    main()
