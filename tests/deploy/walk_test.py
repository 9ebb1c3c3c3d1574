"""Runs the documentation's walk from a study to a table of networks, every command as the page has it.

walk_test.py PAGE BIN: PAGE is deploy/site/docs/walk.md, BIN the folder of the programs."""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def main():
    page, bin_dir = Path(sys.argv[1]), Path(sys.argv[2]).resolve()
    blocks = re.findall(r"^```(yaml)?\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    studies = [text for language, text in blocks if language]
    commands = [line for language, text in blocks if not language for line in text.splitlines()]
    assert len(studies) == 1 and len(commands) >= 7, (len(studies), commands)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "walk.yaml").write_text(studies[0])
        for command in commands:
            done = subprocess.run(["bash", "-euc", command], cwd=folder, capture_output=True, text=True,
                                  env={**os.environ, "PATH": f"{bin_dir}:{os.environ['PATH']}"})
            assert done.returncode == 0, f"{command}: status {done.returncode}\n{done.stdout}\n{done.stderr}"
        table = json.loads((folder / "out/walk/table.json").read_text())
        rows = {row["variant"]: row for row in table["rows"]}
        assert set(rows) == {"narrow", "wide", "sgbm"}, sorted(rows)
        assert all(len(row["benchmarks"]) == 2 for row in rows.values()), rows
        assert (folder / "out/walk/table.txt").stat().st_size > 0
        assert (folder / "out/walk-export/train.txt").stat().st_size > 0
        for published in ("out/walk/wide", "out/walk-export"):
            for file in ("README.md", "LICENSE", "croissant.json"):
                assert (folder / published / file).stat().st_size > 0, (published, file)
    print(f"{len(commands)} commands of {page.name} ran")


if __name__ == "__main__":
    main()
