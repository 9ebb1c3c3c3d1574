"""A trainer for tests of searches: networks of pairs with small disparities are good on the benchmark that comes with
Parallax, all others are wrong everywhere.

  near_trainer.py train --data FOLDER=WEIGHT... --out FOLDER --seed N
  near_trainer.py predict --checkpoint FILE --list FILE"""
import argparse
import json
import pathlib
import statistics
import struct


def train(args: argparse.Namespace) -> None:
    medians = [json.loads(line)["statistics"]["median_disparity_px"]
               for data in args.data
               for line in (pathlib.Path(data.rsplit("=", 1)[0]) / "index.jsonl").read_text().splitlines()]
    is_near = statistics.median(medians) <= 3
    print(json.dumps({"step": 1, "loss": 1.0}), flush=True)
    disparity_px = (20 if is_near else 300) + args.seed % 100  # A confirmation's seeds begin at 100.
    (pathlib.Path(args.out) / "last.json").write_text(json.dumps(disparity_px))


def predict(args: argparse.Namespace) -> None:
    value = json.loads(pathlib.Path(args.checkpoint).read_text())
    for line in pathlib.Path(args.list).read_text().splitlines():
        left, _, output = line.split()
        width, height = struct.unpack(">II", pathlib.Path(left).read_bytes()[16:24])
        pathlib.Path(output).write_bytes(f"Pf\n{width} {height}\n-1\n".encode() + struct.pack("<f", value) * (width * height))


def main() -> None:
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True)
    of_train = commands.add_parser("train")
    of_train.add_argument("--data", action="append", required=True)
    of_train.add_argument("--out", required=True)
    of_train.add_argument("--seed", type=int, required=True)
    of_train.set_defaults(run=train)
    of_predict = commands.add_parser("predict")
    of_predict.add_argument("--checkpoint", required=True)
    of_predict.add_argument("--list", required=True)
    of_predict.set_defaults(run=predict)
    args = parser.parse_args()
    args.run(args)


if __name__ == "__main__":
    main()
