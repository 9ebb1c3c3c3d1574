#!/usr/bin/env python3
"""Checks what must hold between the files of the tree. Fails with a line for each break.

check_tree.py CHECK [ROOT]    the checks are the functions below"""

import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(sys.argv[2] if len(sys.argv) > 2 else Path(__file__).parent.parent).resolve()

# The worker's folders from the bottom up: each may use those on lines above its own. A new folder finds its line here.
WORKER_LEVELS = (
    ("geometry", "materials"),
    ("assets", "terrain"),
    ("layout",),
    ("scene",),
    ("render",),
    ("sensor",),
    ("dataset",),
    ("catalogue", "train"),
    ("evaluate",),
    ("agent",),
    ("jobs",),
)
# The agent uses no other folder: the work of jobs is injected into it.
USES_NO_OTHER = ("agent",)

# The same inside of folders, from the bottom up. A room is a folder, or a file beside the folders: `name` is a pair, `name.h` the header
# alone. A folder's other files stand on top.
INNER_LEVELS = {
    "worker/dataset": ("frame", "archive", "verify export sheets"),
    "worker/render": ("surface", "scene", "lights camera", "raster", "paths", "renderer.h", "film", "truth", "passes"),
    "worker/assets": ("asset.h", "kernel", "asset_families parts detail", "plants", "household building", "furniture lamps nature", "files"),
    "worker/materials": ("kernel", "pictures", "land", "art"),
    "worker/layout": ("anneal/footprint.h", "anneal/wish.h", "anneal/room_table", "plan", "anneal", "rooms"),
    "worker/scene/types/nature": ("rules", "ground", "nature.h", "walk", "biomes"),
    "worker/train": ("network", "contract", "data"),
    "worker/jobs": ("files", "training"),
    "coordinator/http": ("web", "server"),
    "coordinator/queue": ("job_state.h notice.h commands/policy database/fail_point reads/farm_history.h", "job_kind", "ready_key stored_outputs.h study_costs.h", "job_queue.h lease.h", "database", "commands/report_check", "tables", "moves", "commands", "reads", "kinds"),
    "coordinator/client": ("exit_code interrupt", "cancellable", "views/text views/terminal", "app.h connection", "command.h", "views", "content farm scores", "preview runs", "search", "scene_source", "commands"),
}

# A folder has at most so many source files. A registry's folder may have more: one kind, one file.
MOST_FILES = 30
REGISTRIES = ()

# Trees that mirror each other, so that both may have a file of one name.
MIRRORED = {("coordinator/queue/kinds", "worker/jobs")}


def tracked(*patterns):
    """Paths in git, also those not added yet, or of the whole tree where there is no git."""
    done = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns], cwd=ROOT,
                          capture_output=True, text=True)
    if done.returncode != 0:
        return sorted(str(path.relative_to(ROOT)) for pattern in patterns for path in ROOT.rglob(pattern)
                      if not str(path.relative_to(ROOT)).startswith(("build/", "out/")))
    return sorted({path for path in done.stdout.splitlines() if (ROOT / path).is_file()})


def read(path):
    return (ROOT / path).read_text()


def sources(*roots):
    return [path for path in tracked("*.h", "*.cc") if not roots or path.split("/")[0] in roots]


def includes(path):
    """(line number, included path) of our own headers."""
    for number, line in enumerate(read(path).splitlines(), 1):
        match = re.match(r'#include "([^"]+)"', line)
        if match:
            yield number, match.group(1)


# ---- Checks: each yields a line for each break

def registered():
    """Every source, test and migration is listed in the CMakeLists.txt of its folder or of one above it."""
    for path in tracked("*.cc", "*.sql"):
        folder = Path(path).parent
        name = re.compile(r"(?<![\w.])" + re.escape(Path(path).name) + r"(?![\w.])")
        if path.split("/")[0] not in ("common", "coordinator", "worker", "tests"):
            continue
        lists = [parent / "CMakeLists.txt" for parent in (folder, *folder.parents)]
        globs = [f"{file.parent}/{glob}" for file in lists[:2] if (ROOT / file).is_file()
                 for listed in re.findall(r"file\(GLOB \w+ (?:CONFIGURE_DEPENDS )?([^()]+)\)", read(file)) for glob in listed.split()]
        if any(Path(path).match(glob) for glob in globs):
            continue  # A registry's folder takes every file.
        if not any((ROOT / file).is_file() and name.search(read(file)) for file in lists if file != Path("CMakeLists.txt")):
            yield f"{path} is in no CMakeLists.txt"


def parts():
    """Includes point down: common uses itself; coordinator and worker use common; only the client sees both."""
    for path in sources("common", "coordinator", "worker"):
        part = path.split("/")[0]
        for number, header in includes(path):
            other = header.split("/")[0]
            allowed = (other not in ("coordinator", "worker") or other == part
                       or (other == "worker" and path.startswith("coordinator/client/")))
            if not allowed:
                yield f"{path}:{number}: {part} includes {header}"


def worker_order():
    """Within worker/, includes point to folders on lower levels."""
    level_of = {folder: level for level, folders in enumerate(WORKER_LEVELS) for folder in folders}
    for path in sources("worker"):
        folder = path.split("/")[1]
        if "/" not in path[len("worker/"):]:
            continue  # main.cc sees all.
        if folder not in level_of:
            yield f"worker/{folder} has no level in tests/check_tree.py"
            return
        for number, header in includes(path):
            other = header.split("/")[1] if header.startswith("worker/") else folder
            below = level_of.get(other, len(WORKER_LEVELS)) < level_of[folder] and folder not in USES_NO_OTHER
            if other != folder and not below:
                yield f"{path}:{number}: {folder} includes {header}, which stands above it or beside it"


def room_of(path, folder, rooms):
    """The room of INNER_LEVELS that a file belongs to; None: the folder itself."""
    inner = path[len(folder) + 1:]
    names = [inner, inner.rsplit(".", 1)[0]] + [str(parent) for parent in Path(inner).parents if str(parent) != "."]
    return next((name for name in names if name in rooms), None)


def inner_order():
    """Inside of the folders of INNER_LEVELS, includes point to lower levels; rooms of one level do not use each other."""
    for folder, levels in INNER_LEVELS.items():
        level_of = {room: level for level, rooms in enumerate(levels) for room in rooms.split()}
        for path in sources(folder.split("/")[0]):
            if not path.startswith(folder + "/"):
                continue
            room = room_of(path, folder, level_of)
            for number, header in includes(path):
                if not header.startswith(folder + "/") or header.endswith(".pb.h") or header[:-2] == path.rsplit(".", 1)[0]:
                    continue
                other = room_of(header, folder, level_of)
                if other != room and level_of.get(other, len(levels)) >= level_of.get(room, len(levels)):
                    yield f"{path}:{number}: {room or folder} includes {header}, which stands above it or beside it"


def folder_sizes():
    """No folder has more than MOST_FILES source files."""
    files = defaultdict(int)
    for path in tracked("*.h", "*.cc", "*.py", "*.js"):
        files[str(Path(path).parent)] += 1
    for folder, count in sorted(files.items()):
        if count > MOST_FILES and folder not in REGISTRIES:
            yield f"{folder} has {count} source files, at most {MOST_FILES}: give it rooms"


def own_names():
    """No two sources have one name, but for main.cc and those of mirrored trees."""
    folders = defaultdict(list)
    for path in tracked("*.h", "*.cc", "*.py", "*.js"):
        folders[Path(path).name].append(str(Path(path).parent))
    for name, places in sorted(folders.items()):
        if len(places) > 1 and name not in ("main.cc", "__init__.py") and tuple(sorted(places)) not in MIRRORED:
            yield f"{name} is in {', '.join(sorted(places))}"


def readable_ranges():
    """CLI11's PositiveNumber and NonNegativeNumber print bounds of 309 digits; CLI::Range names its own."""
    for path in sources("common", "coordinator", "worker"):
        for number, line in enumerate(read(path).splitlines(), 1):
            if re.search(r"CLI::(PositiveNumber|NonNegativeNumber|Number)\b", line):
                yield f"{path}:{number}: use CLI::Range(low, high)"


def errors_made_one_way():
    """Errors are made by NotFound("...", ...) and its like in common/base/errors.h, or by MakeError of a code that is a
    variable."""
    old = re.compile(r"\babsl::(?!Is|Make)\w+Error\(|\bMakeError\(\s*absl::StatusCode::k")
    for path in sources("common", "coordinator", "worker"):
        if path in ("common/base/status.h", "common/base/errors.h"):
            continue
        text = read(path)
        for match in old.finditer(text):
            number = text.count("\n", 0, match.start()) + 1
            yield f"{path}:{number}: make errors by the functions of common/base/errors.h, as in NotFound(\"{{}}: no such file\", path)"


class Target:
    def __init__(self, folder):
        self.folder = folder
        self.sources, self.public, self.private = [], [], []


def parse_cmake():
    """Targets of the CMakeLists.txt by name, as parallax_library, parallax_test, add_library, add_executable and
    target_link_libraries declare them."""
    targets, alias = {}, {}
    for path in tracked("*CMakeLists.txt"):
        folder = str(Path(path).parent)
        text = re.sub(r"#.*", "", read(path))
        for command, body in re.findall(r"\b(\w+)\s*\(([^()]*(?:\([^()]*\)[^()]*)*)\)", text):
            words = re.findall(r'"[^"]*"|\S+', body)
            if command in ("parallax_library", "parallax_test"):
                name = ("parallax_" if command == "parallax_library" else "") + words[0]
                target = targets.setdefault(name, Target(folder))
                where = None
                for word in words[1:]:
                    if word in ("SOURCES", "DEPS", "PRIVATE_DEPS", "LABELS", "TIMEOUT"):
                        where = {"SOURCES": target.sources, "DEPS": target.public,
                                 "PRIVATE_DEPS": target.private}.get(word)
                    elif where is not None:
                        where.append(word)
                if command == "parallax_library":
                    alias["parallax::" + words[0]] = name
            elif command in ("add_library", "add_executable") and len(words) > 1:
                if words[1] == "ALIAS":
                    alias[words[0]] = words[2]
                else:
                    targets.setdefault(words[0], Target(folder)).sources += words[1:]
            elif command == "target_link_libraries" and words[0] in targets:
                where = targets[words[0]].public
                for word in words[1:]:
                    if word in ("PUBLIC", "INTERFACE", "PRIVATE"):
                        where = targets[words[0]].private if word == "PRIVATE" else targets[words[0]].public
                    else:
                        where.append(word)
    for target in targets.values():
        target.public = [alias.get(name, name) for name in target.public]
        target.private = [alias.get(name, name) for name in target.private]
    return targets


def links():
    """A target links the targets whose headers its sources include, itself or through what those link publicly."""
    targets = parse_cmake()
    owner = {}  # Library of each .cc file.
    for name, target in targets.items():
        for source in target.sources:
            owner.setdefault(f"{target.folder}/{source}", name)

    def reached(name):
        seen, todo = {name}, targets[name].public + targets[name].private
        while todo:
            other = todo.pop()
            if other not in seen:
                seen.add(other)
                todo += targets[other].public if other in targets else []
        return seen

    def needs(path, seen):
        """Targets whose code the headers of a file declare; headers without a .cc stand for what they include."""
        for _, header in includes(path):
            if header in seen or not (ROOT / header).is_file():
                continue
            seen.add(header)
            body = header[:-2] + ".cc"
            if body in owner:
                yield owner[body], header
            else:
                yield from needs(header, seen)

    for name, target in sorted(targets.items()):
        linked = reached(name)
        for source in target.sources:
            path = f"{target.folder}/{source}"
            if not path.endswith(".cc") or not (ROOT / path).is_file():
                continue
            for needed, header in needs(path, set()):
                if needed not in linked:
                    yield f"{path}: {name} includes {header}, but does not link {needed}"


def anchors(text):
    """Anchors of a page's headings, as GitHub and the site make them."""
    found, fenced = set(), False
    for line in text.splitlines():
        fenced ^= line.lstrip().startswith("```")
        if not fenced and re.match(r"#+ ", line):
            name = re.sub(r"[^\w\- ]", "", line.lstrip("# ").strip().lower())
            found.add(name.replace(" ", "-"))
    return found


def documents():
    """Links of Markdown lead to files and headings that are there; so do the sources that their tables name. Text is 120 columns
    wide at most."""
    generated = {f"deploy/site/docs/{page}.md" for page in ("reference/config", "reference/commands", "notebooks/first_steps")}
    names = tracked("*")
    for path in tracked("*.md"):
        fenced = False
        for number, line in enumerate(read(path).splitlines(), 1):
            fenced ^= line.lstrip().startswith("```")
            if len(line) > 120 and not fenced and not line.lstrip().startswith("|") and " " in line.strip()[:100]:
                yield f"{path}:{number}: {len(line)} columns, at most 120"
            if path.endswith(("README.md", "CONTRIBUTING.md", "extend.md")) and line.startswith("|"):
                for named in re.findall(r"`([\w-]+(?:/[\w-]+)*\.(?:cc|h|proto))`", line):
                    if not any(f"/{name}".endswith(f"/{named}") for name in names):
                        yield f"{path}:{number}: no file {named}"
            for target, anchor in re.findall(r"\]\((?![a-z]+:)([^)#\s]*)(?:#([^)\s]*))?\)", re.sub(r"`[^`]*`", "", line)):
                to = (ROOT / path).parent / target if target else ROOT / path
                site = str(to.resolve().relative_to(ROOT)) if to.resolve().is_relative_to(ROOT) else ""
                # The site has deploy/images as images.
                if site.startswith("deploy/site/docs/images/"):
                    to = ROOT / "deploy/images" / to.name
                if site in generated:
                    continue
                if not to.exists():
                    yield f"{path}:{number}: no {target}"
                elif anchor and to.suffix == ".md" and anchor not in anchors(to.read_text()):
                    yield f"{path}:{number}: {target} has no heading #{anchor}"


# For each row of CONTRIBUTING.md's table of what to touch: an example, as the files that must know of it name it.
EXAMPLES = {
    "an asset class": r'"Urchin"',
    "a material": r'"AntiqueMirror"',
    "a config knob": "max_sky_share",
    "a type of scene": "kDenseScenes",
    "a kind of job": "MakeEvaluate(Kind|Handler)",
    "a benchmark": r'"drivingstereo"|driving_stereo\.cc|AddDrivingStereo',
    "a layout of exports": r"\bwmgstereo\b",
}


def touched():
    """The files that CONTRIBUTING.md says to touch are all that name an example of the row."""
    rows = {row.split(" | ")[0].strip("| "): row for row in read("CONTRIBUTING.md").splitlines() if row.startswith("| ")}
    for what, pattern in EXAMPLES.items():
        if what not in rows:
            yield f"CONTRIBUTING.md: no row '{what}'"
            continue
        named = re.findall(r"`([\w./-]+(?:/|\.\w+))`", rows[what])
        found = [path for path in tracked("common/*", "configs/*", "coordinator/*", "worker/*", "proto/*")
                 if path.endswith((".cc", ".h", ".proto", ".yaml", ".txt", ".csv")) and re.search(pattern, read(path))]
        others = [path for path in found if not any(path.startswith(name) or f"/{path}".endswith(f"/{name}") for name in named)]
        if len(others) > rows[what].count("the code that reads it"):
            yield f"CONTRIBUTING.md: '{what}' does not name {', '.join(others)}, which has {pattern}"
        if not found:
            yield f"tests/check_tree.py: no file has {pattern}, the example of '{what}'"


def rulers():
    """A ruler is `// ---- Title`, on one line: nothing that the formatter could break in two."""
    for path in sources():
        for number, line in enumerate(read(path).splitlines(), 1):
            if re.match(r"\s*//\s*-{3,}", line) and not re.fullmatch(r"\s*// ---- [^-].*(?<!-)", line):
                yield f"{path}:{number}: a ruler is `// ---- Title`"


def torn_fields():
    """No declaration is broken in two because a trailing comment did not fit: such a comment goes above it."""
    for path in sources():
        lines = read(path).splitlines()
        for number, (before, line) in enumerate(zip(lines, lines[1:]), 2):
            code = re.match(r"""\s*([^/\s"].*?;)\s+//""", line)
            whole = not before.strip() or re.search(r"""//|[;{},(:]$|^\s*#""", before.rstrip())
            if code and not whole and len(before.rstrip()) + 1 + len(code.group(1)) <= 100:
                yield f"{path}:{number}: the comment tears `{before.strip()} {code.group(1)}` in two; put it above"


# `absl::StatusOr<T> Name(` or `absl::Status Name(` at the beginning of a declaration.
STATUS_FUNCTION = re.compile(r"^\s*(?:\[\[nodiscard\]\] )?(?:static |virtual |inline |explicit |friend )*absl::Status(?:Or<.*?>+)?\s+(\w+)\(")


def undocumented(path):
    """Names of the public functions of a header that return Status or StatusOr and whose comment, or that of their group (no
    blank line between), of their class or of the file, says nothing of errors."""
    comment, head, in_head = "", "", True
    classes = []  # (indentation, comment, access)
    lines = read(path).splitlines()
    statement_done, carried, comment_open = True, "", False
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if text.startswith("//"):
            comment = comment + "\n" + text if comment_open else text
            comment_open = True
            if in_head:
                head += "\n" + text
            continue
        in_head = in_head and text in ("", "#pragma once")
        if not text:
            comment, comment_open, carried = "", False, ""
            continue
        if comment_open:
            carried = comment
        comment_open = False
        opened = re.match(r"(\s*)(?:template .*)?(?:class|struct) (?:\[\[\w+\]\] )?(\w+).*\{$", line)
        if opened and statement_done:
            classes.append([len(opened.group(1)), carried, "private" if " class " in " " + text + " " else "public"])
            carried = ""
        elif re.match(r"\s*(public|protected|private):$", line) and classes:
            classes[-1][2] = text[:-1]
            carried = ""
        elif classes and re.match(r"\s*\};", line) and len(line) - len(line.lstrip()) == classes[-1][0]:
            classes.pop()
        else:
            found = STATUS_FUNCTION.match(line) if statement_done else None
            if found and all(entry[2] == "public" for entry in classes):
                rest = " ".join(lines[number - 1:number + 8])
                declaration = rest[:re.search(r"[;{]", rest).start()] if re.search(r"[;{]", rest) else rest
                trailing = " ".join(re.findall(r"//(.*)", line))
                told = carried + trailing + "".join(entry[1] for entry in classes) + head
                if not re.search(r"\bErrors?\b[ :]", told) and not re.search(r"\boverride\b", declaration):
                    yield found.group(1), number
        code = re.sub(r"//.*", "", text).rstrip()
        statement_done = code.endswith((";", "{", "}", ":")) or text.startswith("#")


def errors():
    """Each function of a public header that returns Status or StatusOr names its errors."""
    for path in sources("common", "coordinator", "worker"):
        if path.endswith(".h"):
            for name, number in undocumented(path):
                yield f"{path}:{number}: {name} does not name its errors (`Errors: ...`)"


def main():
    check = sys.argv[1]
    breaks = list(globals()[check]())
    for line in breaks:
        print(f"{check}: {line}")
    if not breaks:
        print(f"{check}: holds")
    return 1 if breaks else 0


if __name__ == "__main__":
    sys.exit(main())
