#!/usr/bin/env python3
"""Writes a notebook with its outputs as a page: notebook_page.py NOTEBOOK.ipynb PAGE.md. Pictures go beside the page."""
import base64
import json
import pathlib
import sys


def fence(language, text):
    return f"```{language}\n{text.rstrip()}\n```\n"


def shown(output, stem):
    """Markdown of an output; a picture is written to a file whose name begins with `stem`."""
    if output["output_type"] == "stream":
        return fence("text", "".join(output["text"]))
    data = output.get("data", {})
    if "image/png" in data:
        path = stem.with_name(stem.name + ".png")
        path.write_bytes(base64.b64decode("".join(data["image/png"])))
        return f"![Output]({path.name})\n"
    return fence("text", "".join(data.get("text/plain", output.get("traceback", []))))


def main():
    notebook, page = map(pathlib.Path, sys.argv[1:])
    parts = []
    for number, cell in enumerate(json.loads(notebook.read_text())["cells"]):
        source = "".join(cell["source"])
        parts.append(source + "\n" if cell["cell_type"] == "markdown" else fence("python", source))
        for index, output in enumerate(cell.get("outputs", [])):
            parts.append(shown(output, page.with_name(f"{page.stem}_{number}_{index}")))
    page.write_text("\n".join(parts) + f"\nThe notebook as a [file]({notebook.name}).\n")


if __name__ == "__main__":
    main()
