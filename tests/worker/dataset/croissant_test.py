"""Validates croissant.json of an archive and of every export with `mlcroissant`, and reads their tables with it.

croissant_test.py MAKE_EXPORTS PYTHON: PYTHON is the one of setup_python.sh's environment; without it the test is
skipped (exit status 77)."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SKIPPED = 77


def records(folder):
    import mlcroissant
    dataset = mlcroissant.Dataset(str(folder / "croissant.json"))
    issues = dataset.metadata.ctx.issues
    assert not issues.errors, (folder, issues.errors)
    # A date of publication would make the file differ from run to run.
    assert all("datePublished" in warning for warning in map(str, issues.warnings)), (folder, issues.warnings)
    rows = [{name.removeprefix("pairs/"): value for name, value in row.items()} for row in dataset.records("pairs")]
    return [{name: value.decode() if isinstance(value, bytes) else value for name, value in row.items()}
            for row in rows]


def check(folder, wanted):
    rows = records(folder)
    assert len(rows) == len(wanted), (folder, len(rows), len(wanted))
    for row, want in zip(rows, wanted):
        assert row == {name: want[name] for name in row}, (folder, row, want)


def main():
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        subprocess.run([sys.argv[1], name], check=True)
        archive = root / "archive" / "a"
        check(archive, [json.loads(line) for line in (archive / "index.jsonl").read_text().splitlines()])
        exports = sorted(path.parent for path in root.glob("*/export.json"))
        assert len(exports) == 11, exports
        for export in exports:
            check(export, json.loads((export / "export.json").read_text())["frames"])
    print(f"{len(exports) + 1} datasets are valid")


if __name__ == "__main__":
    python = sys.argv[2]
    if subprocess.run([python, "-c", "import mlcroissant"], capture_output=True).returncode != 0 \
            if os.path.exists(python) else True:
        print(f"skipped: {python} lacks mlcroissant; tests/worker/dataset/setup_python.sh makes it")
        sys.exit(SKIPPED)
    if os.path.realpath(sys.prefix) != os.path.realpath(Path(python).parents[1]):
        os.execve(python, [python, "-B", *sys.argv], os.environ)
    main()
