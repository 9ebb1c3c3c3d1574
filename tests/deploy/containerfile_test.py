"""The image can be built from a tree in which the quickstart has run: copies what deploy/Containerfile would copy (all but
what .dockerignore names), then configures and plans the build as the Containerfile does. Needs no container engine.

containerfile_test.py SOURCE_FOLDER"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# Files that a build, a run and an installation of the Python package leave behind.
LEFT_BEHIND = {
    "build/release/CMakeCache.txt": "CMAKE_HOME_DIRECTORY:INTERNAL=/another/machine\n"
                                    "CMAKE_CACHEFILE_DIR:INTERNAL=/another/machine/build/release\n",
    "build/configure.log": "", "out/quickstart/index.jsonl": "{}\n", ".git/HEAD": "ref: refs/heads/main\n",
    "common/python/parallax_data/build/lib/parallax_data/exr.py": "",
    "common/python/parallax_data/parallax_data.egg-info/PKG-INFO": "",
    "common/python/parallax_data/parallax_data/__pycache__/exr.cpython-311.pyc": "",
}


def ignore_rules(text):
    """(excludes, regular expression) of each line of a .dockerignore."""
    rules = []
    for line in text.splitlines():
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        pattern = line.lstrip("!").strip("/")
        expression = ""
        for part in re.split(r"(\*\*/|\*\*|\*|\?)", pattern):
            expression += {"**/": "(.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}.get(part, re.escape(part))
        rules.append((not line.startswith("!"), re.compile(expression)))
    return rules


def is_ignored(path, rules):
    """The last rule that fits the path or a folder above it decides."""
    parts = path.split("/")
    ignored = False
    for excludes, expression in rules:
        if any(expression.fullmatch("/".join(parts[:n])) for n in range(1, len(parts) + 1)):
            ignored = excludes
    return ignored


def build_commands(containerfile):
    """The first two commands of the RUN line after `COPY . .`: configure and build."""
    run = re.search(r"^COPY \. \.\nRUN (.*)", containerfile.replace("\\\n", " "), re.MULTILINE).group(1)
    configure, build = run.split("&&")[:2]
    return shlex.split(configure), shlex.split(build)


def main(source):
    rules = ignore_rules((source / ".dockerignore").read_text())
    tracked = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=source, capture_output=True, text=True,
                             check=True).stdout.split("\0")[:-1]
    kept = [path for path in LEFT_BEHIND if not is_ignored(path, rules)]
    assert not kept, f".dockerignore lets {kept} into the image"
    configure, build = build_commands((source / "deploy" / "Containerfile").read_text())
    with tempfile.TemporaryDirectory() as folder:
        context = Path(folder) / "src"
        for path in tracked:
            if not is_ignored(path, rules) and (source / path).is_file():
                (context / path).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source / path, context / path)
        assert not (context / "tests").exists()
        # A cache from elsewhere must not matter either.
        for path, text in LEFT_BEHIND.items():
            if path.startswith("build/"):
                (context / path).parent.mkdir(parents=True, exist_ok=True)
                (context / path).write_text(text)
        environment = {k: v for k, v in os.environ.items() if k not in ("CMAKE_BUILD_PARALLEL_LEVEL",)}
        for command in (configure, build + ["--", "-n"]):
            done = subprocess.run(command, cwd=context, env=environment, capture_output=True, text=True)
            assert done.returncode == 0, f"{shlex.join(command)}: {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        for program in ("coordinator", "worker", "parallax"):
            assert f"bin/{program}" in done.stdout, f"no bin/{program} in the plan of the build"
    print(f"{len(tracked)} files in the tree; the image configures and has a plan to build")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
