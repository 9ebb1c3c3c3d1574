"""Runs the code of the documentation's notebook, with fewer pairs and steps.

notebook_test.py NOTEBOOK BIN [PACKAGE]: BIN is the folder of the programs, PACKAGE that of parallax_data if that is not
installed. Pictures are not drawn where matplotlib is missing."""

import json
import os
import re
import sys
import tempfile
from pathlib import Path
from unittest import mock


def main():
    notebook, bin_dir, *package = (Path(argument).resolve() for argument in sys.argv[1:])
    cells = [c for c in json.loads(notebook.read_text())["cells"] if c["cell_type"] == "code"]
    source = "\n\n".join("".join(cell["source"]) for cell in cells)
    source, changed = re.subn(r"^(PAIRS|STEPS) = \d+", lambda m: m[1] + " = 2", source, flags=re.MULTILINE)
    assert changed == 2, changed
    os.environ["PATH"] = f"{bin_dir}:{os.environ['PATH']}"
    os.environ["MPLBACKEND"] = "Agg"
    sys.path[:0] = map(str, package)
    try:
        import matplotlib.pyplot  # noqa: F401
    except ImportError:
        pyplot = mock.MagicMock()
        pyplot.subplots.return_value = (mock.MagicMock(), [mock.MagicMock() for _ in range(3)])
        sys.modules["matplotlib"], sys.modules["matplotlib.pyplot"] = mock.MagicMock(pyplot=pyplot), pyplot
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        seen = {"__name__": "notebook"}
        exec(compile(source, notebook.name, "exec"), seen)  # pylint: disable=exec-used
        assert len(seen["data"]) == 2 and seen["worst"] < 1e-2, (len(seen["data"]), seen["worst"])
        assert len(seen["steps"]) >= 1, seen["steps"]
        assert Path("out/notebook-scores/network").exists() and Path("out/notebook-scores/sgbm").exists()
    print(f"{len(cells)} cells of {notebook.name} ran")


if __name__ == "__main__":
    main()
