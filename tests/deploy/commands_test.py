"""Runs every fenced command of README and documentation, with smaller pictures, fewer pairs and fewer steps.

commands_test.py --bin BIN [--tree SOURCE] [--dist DIST] [--has WORD]... PAGE...
BIN is the folder of the programs (of a build, or of an installed package). Each page runs in a folder of its own, its
fences in order; the pairs of one page serve the next. The first line of a fence says what it is:

  ```            or ```sh: commands, run by bash; lines that start a coordinator or a worker go to the background
  ```python      run by this Python
  ```yaml        a study, a land or a kind of room, which `parallax config check`, `biome` or `room` must accept; file=NAME
                 writes it as NAME before all commands; other files and parts of files are named as not tried
  ```text        no command; other languages too are only allowed if NO_COMMANDS has them
  needs=WORD     the fence needs more than Parallax: NEEDS says what. It is skipped, visibly, unless --has names it
  after=PAGE     the page goes on in the folder of another page

The farm's names and ports become loopback's. The last line counts what ran and what was skipped."""

import argparse
import json
import os
import re
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

NO_COMMANDS = {"text", "bibtex", "json"}
NEEDS = {
    "network": "what a package registry or another host has",
    "packages": "the files of deploy/package.sh in dist/, pip and sudo",
    "hours": "hours of computing",
    "slurm": "a Slurm cluster",
    "kubernetes": "a Kubernetes cluster",
    "gpu": "a GPU",
    "cloud": "an account with a cloud",
    "files": "files of your own",
    "opencv": "Python's OpenCV, and files of a clone or of your own",
}
FENCE_LIMIT_S = 600
# What makes the commands short. Pairs, sizes and samples that a page names are replaced.
SMALL = "--pairs 2 --rigs 2 --profile preview --samples 1 --width {} --height {}"
TO_TRAIN, TO_SEE = (416, 234), (208, 117)  # The built-in trainer's crops are of 384 x 192.
# A network of two steps misses nearly all pixels, and `curate` would leave no pair.
SHORTER_TRAINING = [(r"--steps \d+", "--steps 2"), (r"--max-share \S+", "--max-share 0.999")]
SHORTER_STUDIES = [(r"\bsteps: \d+", "steps: 2"), (r"\bseeds: \d+", "seeds: 1"), (r"\bheldout_pairs: \d+", "heldout_pairs: 1")]
# Starts LINE in the background; waits until a coordinator listens. Another coordinator takes the place of the first.
BACKGROUND = """
background() {
  if [ "$1" = coordinator ] && [ -e coordinator.pid ]; then
    kill $(cat coordinator.pid)
    while kill -0 $(cat coordinator.pid) 2>/dev/null; do sleep 0.1; done
  fi
  "$@" >>background.log 2>&1 &
  echo $! >>background.pids
  if [ "$1" = coordinator ]; then
    echo $! >coordinator.pid
    for _ in $(seq 300); do
      if (exec 3<>/dev/tcp/127.0.0.1/$PARALLAX_TEST_PORT) 2>/dev/null; then return; fi
      sleep 0.1
    done
    cat background.log; return 1
  fi
}
"""


class Fence:
    def __init__(self, page, line, head, text):
        self.page, self.text = page, text
        self.where = f"{page}:{line}"
        match = re.fullmatch(r"(\w*)((?: +\w+=\S+)*)", head.strip())
        assert match, f"{self.where}: ```{head}: expected a language and attributes like needs=slurm"
        self.language = match[1] or "sh"
        self.attributes = dict(re.findall(r"(\w+)=(\S+)", match[2]))
        for name in self.attributes:
            assert name in {"needs", "file", "after"}, f"{self.where}: unknown attribute {name}"
        self.needs = self.attributes.get("needs")
        assert self.needs is None or self.needs in NEEDS, f"{self.where}: needs={self.needs}, known are {sorted(NEEDS)}"
        found = re.search(r"^(landform|furniture):", text, re.MULTILINE)
        self.checked_by = ({"landform": "biome", "furniture": "room"}[found[1]] if found else
                           "check" if text.startswith(("study:", "extends:", "variants:")) else None)
        assert self.language in NO_COMMANDS | {"sh", "bash", "python", "yaml"}, f"{self.where}: language {self.language}"


def fences_of(page, name):
    """The fences of a page; those of lists are indented."""
    found, opened = [], None
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if opened is None:
            match = re.fullmatch(r"( *)```(.*)", line)
            if match:
                opened, indent, head, lines = number, len(match[1]), match[2], []
        elif line.strip() == "```":
            found.append(Fence(name, opened, head, "".join(lines)))
            opened = None
        else:
            lines.append(line[indent:] + "\n")
    assert opened is None, f"{name}:{opened}: the fence does not end"
    return found


def cpu_seconds():
    """Of children that have ended: not of those in the background."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def replace_all(pairs, text):
    for pattern, by in pairs:
        text = re.sub(pattern, by, text)
    return text


def short_commands(text, size):
    text = text.replace("\\\n", " ")
    lines = []
    for line in text.splitlines():
        if re.match(r"parallax (run|submit) ", line):
            line = re.sub(r" --(pairs|rigs|width|height|profile|samples) \S+", "", line)
            line = re.sub(r"\bparallax (run|submit) ", rf"parallax \1 {SMALL.format(*size)} ", line)
            line = line.replace("parallax run ", "parallax run --workers 1 ")  # Two would build each scene twice.
        line = replace_all(SHORTER_TRAINING, line)
        if re.match(r"(coordinator serve|worker) ", line):
            line = "background " + line
        lines.append(line)
    return "\n".join(lines) + "\n"


def shipped_pair(bin_dir):
    """The real pair of a package or of a clone, as a line of a list."""
    packed = "share/parallax/benchmarks/shipped"
    found = [*bin_dir.parent.glob(f"lib/python*/site-packages/parallax_stereo/{packed}"), bin_dir.parent / packed,
             Path("/opt/parallax/benchmarks/shipped")]
    folder = next(folder for folder in found if folder.is_dir())
    return " ".join(f'"{folder}/motorcycle_{name}"' for name in ("left.png", "right.png", "disp.npy"))


class Page:
    """A folder in which the fences of a page run, with the ports of its farm."""

    def __init__(self, folder, bin_dir, tree, dist, store, size):
        self.folder, self.size = Path(folder), size
        self.ports = free_port(), free_port()
        self.environment = {**os.environ, "PATH": f"{bin_dir}:{os.environ['PATH']}", "PYTHONDONTWRITEBYTECODE": "1",
                            "PARALLAX_TEST_PORT": str(self.ports[0]), "PARALLAX_COORDINATOR": f"127.0.0.1:{self.ports[0]}",
                            "PARALLAX_STORE": str(store)}
        # Whoever has a camera has a list of its pairs.
        (self.folder / "pairs.txt").write_text(shipped_pair(bin_dir) + "\n")
        if dist:
            (self.folder / "dist").symlink_to(dist)
        if tree:
            for name in ("tests", "configs", "deploy"):
                (self.folder / name).symlink_to(tree / name)
            self.environment["PYTHONPATH"] = f"{tree}/common/python/parallax_data"

    def on_loopback(self, text):
        for name in ("farm.example.org", "login.example.org"):
            text = text.replace(name, "localhost")
        text = re.sub(r"\b(localhost|127\.0\.0\.1|0\.0\.0\.0):7070\b",
                      lambda m: f"{m[1].replace('0.0.0.0', '127.0.0.1')}:{self.ports[0]}", text)
        return text.replace(":7080", f":{self.ports[1]}")

    def write(self, fence):
        name = fence.attributes.get("file", "study-of-page.yaml")
        text = "study: fragment\nbase: indoor\npairs: 4\n" + fence.text if fence.text.startswith("variants:") else fence.text
        (self.folder / name).write_text(replace_all(SHORTER_STUDIES, text))
        return name

    def run(self, fence):
        if fence.language == "yaml":
            script = f"parallax config {fence.checked_by} {self.write(fence)}"
        elif fence.language == "python":
            (self.folder / "fence.py").write_text(fence.text)
            script = f"'{sys.executable}' fence.py"
        else:
            script = BACKGROUND + self.on_loopback(short_commands(fence.text, self.size))
        # A file takes the output: whoever runs in the background would hold a pipe open.
        with open(self.folder / "output.log", "w+") as output:
            done = subprocess.Popen(["bash", "-euo", "pipefail", "-c", script], cwd=self.folder, env=self.environment,
                                    stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)
            try:
                status = done.wait(FENCE_LIMIT_S)
            except subprocess.TimeoutExpired:
                done.kill()
                status = f"still running after {FENCE_LIMIT_S} s"
        if status == 0:
            return
        said = (self.folder / "output.log").read_text()
        behind = self.folder / "background.log"
        said += behind.read_text() if behind.exists() else ""
        raise AssertionError(f"{fence.where}: status {status}\n{script.removeprefix(BACKGROUND)}\n{said[-4000:]}")

    def stop(self):
        """Ends what runs in the background, the last one first: workers hand back their jobs before the farm ends."""
        pids = self.folder / "background.pids"
        for pid in map(int, reversed(pids.read_text().split())) if pids.exists() else ():
            for number in [signal.SIGTERM] + 100 * [0] + [signal.SIGKILL]:
                try:
                    os.kill(pid, number)
                except ProcessLookupError:
                    break
                time.sleep(0.1)
        pids.unlink(missing_ok=True)


def check_walk(folder):
    """The walk ends in a table of its variants and what can be published."""
    table = json.loads((folder / "out/walk/table.json").read_text())
    rows = {row["variant"]: row for row in table["rows"]}
    assert set(rows) == {"narrow", "wide", "sgbm"}, sorted(rows)
    assert all(len(row["benchmarks"]) == 2 for row in rows.values()), rows
    assert (folder / "out/walk/table.txt").stat().st_size > 0
    assert (folder / "out/walk-export/train.txt").stat().st_size > 0
    for published in ("out/walk/wide", "out/walk-export"):
        for file in ("README.md", "LICENSE", "croissant.json"):
            assert (folder / published / file).stat().st_size > 0, (published, file)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--bin", type=Path, required=True)
    arguments.add_argument("--tree", type=Path, help="the repository, for its reader in Python")
    arguments.add_argument("--dist", type=Path, help="the packages, dist/ of the commands that install them")
    arguments.add_argument("--has", action="append", default=[], choices=sorted(NEEDS))
    arguments.add_argument("pages", nargs="+", type=Path)
    options = arguments.parse_args()
    ran = skipped = 0
    pages = {}
    fences_by_path = {path: fences_of(path, "/".join(path.parts[-2:])) for path in options.pages}
    after_by_path = {path: next((fence.attributes["after"] for fence in fences if "after" in fence.attributes), None)
                     for path, fences in fences_by_path.items()}
    trained = {after_by_path[path] or path.name for path, fences in fences_by_path.items()
               if any(re.search(r"\btrain", fence.text) for fence in fences)}
    with tempfile.TemporaryDirectory() as work:
        try:
            for path, fences in fences_by_path.items():
                name, after = "/".join(path.parts[-2:]), after_by_path[path]
                if after:
                    assert after in pages, f"{name}: after={after}, which was not run before it"
                    page = pages[after]
                else:
                    folder = Path(work) / str(len(pages))
                    folder.mkdir()
                    page = Page(folder, options.bin.resolve(), options.tree and options.tree.resolve(),
                                options.dist and options.dist.resolve(), Path(work) / "store",
                                TO_TRAIN if path.name in trained else TO_SEE)
                pages[path.name] = page
                for fence in fences:
                    if "file" in fence.attributes:
                        page.write(fence)
                for fence in fences:
                    if fence.language in NO_COMMANDS:
                        continue
                    if fence.language == "yaml" and not fence.checked_by:
                        print(f"not tried {fence.where}: {fence.attributes.get('file', 'a part of a file')}", flush=True)
                        continue
                    if fence.needs and fence.needs not in options.has:
                        skipped += 1
                        print(f"skipped {fence.where}: needs {NEEDS[fence.needs]}", flush=True)
                        continue
                    start_s, start_cpu_s = time.monotonic(), cpu_seconds()
                    page.run(fence)
                    ran += 1
                    print(f"ran {fence.where} in {time.monotonic() - start_s:.0f} s, {cpu_seconds() - start_cpu_s:.0f} core-s", flush=True)
                if path.name == "walk.md":
                    check_walk(page.folder)
                if not after and path.name not in after_by_path.values():
                    page.stop()
        finally:
            for page in pages.values():
                page.stop()
    assert ran > 0, "no fence ran"
    print(f"{ran} fences ran, {skipped} were skipped")


if __name__ == "__main__":
    main()
