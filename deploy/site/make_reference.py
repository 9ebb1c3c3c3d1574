#!/usr/bin/env python3
"""Writes the generated pages of the documentation and the JSON Schemas of config files.

Sources: the comments and FieldRules of proto/parallax/v1/*.proto, and the programs' own --help.
  make_reference.py config --proto proto --out DIR     config.md, and a schema each of studies, scenes, lands
  make_reference.py commands --bin build/release/bin --out DIR     commands.md
"""
import argparse
import importlib
import json
import pathlib
import subprocess
import sys
import tempfile

PROTOS = ("rule", "biome", "room", "engine", "config", "jobs", "scene", "train", "study")
# Headings of the page: title, message, path of its fields in a file.
SECTIONS = (("Scenes", "SceneConfig", ""), ("Lands", "Biome", ""), ("Rooms", "RoomKind", ""), ("Engines", "Engine", ""), ("Streams", "StreamSpec", "stream"), ("Searches", "SearchSpec", "search"), ("Notices", "NotifySpec", "notify"), ("Training", "TrainSpec", "train"), ("Evaluating", "EvaluateSpec", "evaluate"))
# Fields of a study file that no message has in that form; the others have the comments of StudySpec and VariantSpec.
OF_A_STUDY = {"study": "name", "rigs_per_scene": "", "seed": "", "priority": "", "tags": "", "memory_mb": ""}
WORDS = {
    "extends": "Another study, built in or a file, that this file continues: its fields are the defaults of all fields here. "
               "Variants of the same name are merged, new ones are added.",
    "base": "A scene config, built in (`indoor`, `dense`, `nature`, `street`) or a file, onto which `set` is merged. "
            "Absent: every field at its default.",
    "set": "Fields of the scene config that differ from the base, for all variants.",
    "variants": "The datasets of the study; they should differ in one thing.",
    "variants[].base": "As `base`, for this variant.",
    "variants[].set": "As `set`, for this variant; it overrides the study's.",
    "variants[].config": "In place of `base` and `set`: the whole scene config, as study.lock.yaml has it.",
    "pairs": "Pairs of each variant; `endless`: pairs are rendered while trainings take them (`parallax stream`).",
    "stream": "How the pairs of an endless study are made and kept; fields below. Only with `pairs: endless`.",
    "search": "Searches for the settings whose pairs train best (`parallax search`), in place of `variants`; fields below.",
    "notify": "Receiver of a notice when the study ends, stalls or needs a person; fields below. Absent: none.",
    "train": "Trains networks on each variant; fields below. Absent: no training.",
    "evaluate": "Scores the networks; fields below. Absent: no evaluation.",
}
DISTRIBUTION = "A number, or `{uniform: [low, high]}`, `{uniform_int: [low, high]}`, `{choice: [...]}`, " \
               "`{clip_gaussian: [mean, std, low, high]}`, `{bernoulli: p}`: drawn anew for each use."


# Messages that a file writes on one line.
SHORT = {"Quantity": "distribution or formula", "SoftSpan": "[low, high, soft]",
         "GroundPatches": "[wavelength_m, cover, soft]", "GroundRows": "[spacing_m, width_m, direction_deg]",
         "SizeSpan": "[low, high]", "CountSpan": "[low, high]", "GapSpan": "[near, far]",
         "SearchField": "a map from fields to `{range: [low, high], log: true}` or `{choice: [...]}`, each with `when: {field: choice}`"}
# Messages that files of their own fill, and what such a file is of.
OF_FILES = {".parallax.v1.Biome": "a land", ".parallax.v1.RoomKind": "a kind of room"}
ABOUT = {"Lands": "A file of a land has these fields: the built-in ones in `configs/biomes`, and yours, which "
                  "[`nature.biome_files`](../recipes/nature.md) names. `parallax config biome FILE` checks it. A number is a "
                  "distribution, or a formula with +, - and * of numbers and names: those that `let` gives, and `low_m`, "
                  "`middle_m`, `high_m`, `relief_m` (heights of the site), `beach_m` (how high a beach reaches above the "
                  "water), `gorge_m` (width of a gorge).",
         "Rooms": "A file of a kind of room has these fields: the built-in ones in `configs/rooms`, and yours, which "
                  "[`room.room_files`](../recipes/rooms.md) names. `parallax config room FILE` checks it.",
         "Engines": "A file of a batch system has these fields: the built-in ones in `configs/engines`, and yours, which "
                    "[`parallax farm FILE`](../recipes/slurm.md#another-batch-system) names."}


def load_files(proto_dir):
    """FileDescriptorProtos by message name, and the FieldRule extension."""
    with tempfile.TemporaryDirectory() as work:
        files = [f"parallax/v1/{name}.proto" for name in PROTOS]
        subprocess.run(["protoc", "-I", proto_dir, f"--python_out={work}", "--include_source_info",
                        "--include_imports", f"--descriptor_set_out={work}/set.pb", *files], check=True)
        sys.path.insert(0, work)
        rules = importlib.import_module("parallax.v1.rule_pb2")
        from google.protobuf import descriptor_pb2
        found = descriptor_pb2.FileDescriptorSet.FromString(pathlib.Path(work, "set.pb").read_bytes())
    return [f for f in found.file if f.name.startswith("parallax/")], rules


class Schema:
    """Messages and enums by full name, with their comments."""

    def __init__(self, files, rules):
        self.rules, self.messages, self.enums, self.comments = rules, {}, {}, {}
        self.without_meaning = []
        for file in files:
            comments = {tuple(l.path): (l.leading_comments + l.trailing_comments).strip()
                        for l in file.source_code_info.location}
            for i, message in enumerate(file.message_type):
                self._add(f".{file.package}", message, (4, i), comments)
            for i, enum in enumerate(file.enum_type):
                self.enums[f".{file.package}.{enum.name}"] = (enum, comments, (5, i))

    def _add(self, scope, message, path, comments):
        name = f"{scope}.{message.name}"
        self.messages[name] = message
        self.comments[name] = comments.get(path, "")
        for i, field in enumerate(message.field):
            self.comments[f"{name}.{field.name}"] = comments.get(path + (2, i), "")
        for i, nested in enumerate(message.nested_type):
            self._add(name, nested, path + (3, i), comments)
        for i, enum in enumerate(message.enum_type):
            self.enums[f"{name}.{enum.name}"] = (enum, comments, path + (4, i))

    def rule(self, field):
        return field.options.Extensions[self.rules.rule]

    def enum_values(self, type_name):
        enum, comments, path = self.enums[type_name]
        words = []
        prefix = "".join("_" + c if c.isupper() else c for c in enum.name).upper().lstrip("_") + "_"
        for i, value in enumerate(enum.value):
            if value.number == 0:
                continue
            word = value.name[len(prefix):].lower() if value.name.startswith(prefix) else value.name.lower()
            words.append((word, one_line(comments.get(path + (2, i), ""))))
        return words


def one_line(text):
    """The comment without the headings ("---- In study files") that its file has between messages."""
    return " ".join(" ".join(line for line in text.splitlines() if not line.strip().startswith("----")).split())


def is_distribution(field):
    return field.type_name.endswith(".Distribution")


def is_group(schema, field):
    return field.type == field.TYPE_MESSAGE and not is_distribution(field) and not short_form(field) \
        and field.type_name in schema.messages


def short_form(field):
    return SHORT.get(field.type_name.rsplit(".", 1)[-1], "")


def texts_of(schema, name, field):
    """The list of texts whose items that are maps `field` takes ("benchmarks" of "own_benchmarks"); "" for others."""
    listed = field.name.removeprefix("own_")
    texts = any(f.name == listed != field.name and f.type == f.TYPE_STRING for f in schema.messages[name].field)
    return listed if texts and field.type_name not in OF_FILES else ""


def bounds(rule):
    parts = []
    if rule.HasField("min") or rule.HasField("max"):
        low = f"{rule.min:g}" if rule.HasField("min") else "-"
        high = f"{rule.max:g}" if rule.HasField("max") else "-"
        parts.append(f"{low} to {high}" + (f" {rule.unit}" if rule.unit else ""))
    if rule.allowed:
        parts.append(", ".join(f"`{a}`" if a else "empty" for a in rule.allowed))
    return "; ".join(parts)


def meaning(schema, name, field):
    text = one_line(schema.comments[f"{name}.{field}"])
    if not text:
        schema.without_meaning.append(f"{name.removeprefix('.parallax.v1.')}.{field}")
    return text


def row(schema, name, field):
    """(default, allowed, meaning) of a field that is no group."""
    rule = schema.rule(field)
    allowed = bounds(rule)
    if field.type == field.TYPE_ENUM:
        values = [v for v in schema.enum_values(field.type_name) if not rule.allowed or v[0] in rule.allowed]
        allowed = ", ".join(f"`{word}`" for word, _ in values)
        comment = one_line(schema.comments[f"{name}.{field.name}"])
        comment = " ".join([comment] + [f"`{w}`: {c}" for w, c in values if c]).strip()
        return rule.default_yaml, allowed, comment or meaning(schema, name, field.name)
    if is_distribution(field):
        allowed = "distribution" + (f", {allowed}" if allowed else "")
    if short := short_form(field):
        allowed = short + (f", {allowed}" if allowed else "")
    return rule.default_yaml, allowed, meaning(schema, name, field.name)


def groups(schema, name, path, comment, found):
    """Into `found`, by message: the paths of its groups, what is said of them, and the rows of the fields."""
    new = name not in found
    about = " ".join(filter(None, [comment, one_line(schema.comments[name])]))
    paths, _, own = found.setdefault(name, ([], about, []))
    paths.append(path)
    for field in schema.messages[name].field:
        below = f"{path}.{field.name}" if path else field.name
        listed = texts_of(schema, name, field)
        if is_group(schema, field):
            repeated = field.label == field.LABEL_REPEATED
            about = one_line(schema.comments[f"{name}.{field.name}"])
            file = OF_FILES.get(field.type_name)
            if (repeated and not listed or file) and new:
                own.append((field.name, "", file or "list", meaning(schema, name, field.name)))
            if file:
                continue  # Has a part of its own.
            groups(schema, field.type_name, (f"{path}.{listed}" if listed else below) + ("[]" if repeated else ""),
                   "" if repeated else about, found)
        elif new:
            own.append((field.name, *row(schema, name, field)))


def table(head, rows):
    yield from [head, "|---" * (head.count("|") - 1) + "|"]
    for cells in rows:
        yield "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"
    yield ""


def study_meanings(schema):
    """What each word of a study file means, by its path."""
    found = {word: meaning(schema, ".parallax.v1.StudySpec", field or word) for word, field in OF_A_STUDY.items()}
    for word in ("name", "pairs", "rigs_per_scene", "seed"):
        found[f"variants[].{word}"] = meaning(schema, ".parallax.v1.VariantSpec", word)
    return found | WORDS


def write_config_page(schema, out):
    lines = ["# Config reference", "",
             "Made from the comments in `proto/parallax/v1`. A field that is absent takes its default; an unknown one "
             "is an error that names file, line and the nearest field.", "",
             "**Distribution**: " + DISTRIBUTION, "", "## Studies", "",
             "A study file has these fields. `parallax config check FILE` checks it.", ""]
    lines += table("| field | meaning |", [(f"`{word}`", text) for word, text in study_meanings(schema).items()])
    for title, message, path in SECTIONS:
        lines += [f"## {title}", ""] + ([ABOUT[title], ""] if title in ABOUT else [])
        found = {}
        groups(schema, f".parallax.v1.{message}", path, "", found)
        for paths, about, rows in found.values():
            if any(paths):
                lines += ["### " + ", ".join(f"`{p}`" for p in paths), ""]
            lines += [about, ""] if about else []
            lines += table("| field | default | allowed | meaning |",
                           [(f"`{name}`", f"`{default}`" if default else "", allowed, text)
                            for name, default, allowed, text in rows]) if rows else []
    (out / "config.md").write_text("\n".join(lines))


def distribution_schema():
    numbers = {"type": "array", "items": {"type": "number"}}
    return {"oneOf": [{"type": "number"}] + [
        {"type": "object", "properties": {kind: shape}, "required": [kind], "additionalProperties": False}
        for kind, shape in (("uniform", numbers), ("uniform_int", numbers), ("choice", numbers),
                            ("clip_gaussian", numbers), ("bernoulli", {"type": "number"}))]}


def field_schema(schema, name, field):
    rule = schema.rule(field)
    if is_distribution(field):
        item = {"$ref": "#/$defs/Distribution"}
    elif field.type_name.endswith(".Quantity"):
        item = {"anyOf": [{"$ref": "#/$defs/Distribution"}, {"type": "string"}]}
    elif short_form(field):
        item = {"$ref": "#/$defs/Numbers"}
    elif field.type_name in OF_FILES:
        item = {"$ref": "#/$defs/" + field.type_name.rpartition(".")[2]}
    elif field.type == field.TYPE_ENUM:
        words = list(rule.allowed) or [word for word, _ in schema.enum_values(field.type_name)]
        # YAML 1.1 reads on and off as true and false.
        item = {"enum": words + ([True, False] if "on" in words else [])}
    elif is_group(schema, field):
        item = message_schema(schema, field.type_name)
    elif field.type == field.TYPE_BOOL:
        item = {"type": "boolean"}
    elif field.type == field.TYPE_STRING:
        item = {"enum": list(rule.allowed)} if rule.allowed else {"type": "string"}
    else:
        whole = field.type not in (field.TYPE_DOUBLE, field.TYPE_FLOAT)
        item = {"type": "integer" if whole else "number"}
        if rule.HasField("min"):
            item["minimum"] = rule.min
        if rule.HasField("max"):
            item["maximum"] = rule.max
    if field.label == field.LABEL_REPEATED:
        item = {"type": "array", "items": item}
    comment = one_line(schema.comments[f"{name}.{field.name}"])
    if comment:
        item["description"] = comment
    return item


def message_schema(schema, name):
    properties = {f.name: field_schema(schema, name, f) for f in schema.messages[name].field}
    for field in schema.messages[name].field:
        if listed := texts_of(schema, name, field):
            maps = properties.pop(field.name)["items"]
            properties[listed]["items"] = {"anyOf": [properties[listed]["items"], maps]}
    # Lands of the user's own have weights by their names.
    others = {"type": "number"} if name.endswith(".BiomeWeights") else False
    return {"type": "object", "additionalProperties": others, "properties": properties}


def search_schema(schema):
    """A search, whose space a file writes as a map from fields to what they may be (common/config/search/search_space.cc)."""
    search = message_schema(schema, ".parallax.v1.SearchSpec")
    numbers = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    field = {"type": "object", "additionalProperties": False, "properties": {
        "range": numbers, "log": {"type": "boolean"}, "choice": {"type": "array", "minItems": 2}, "when": {"type": "object"}},
        "oneOf": [{"required": ["range"]}, {"required": ["choice"]}]}
    said = search["properties"]["space"]["description"]
    search["properties"]["space"] = {"type": "object", "additionalProperties": field, "description": said}
    return search


def write_json_schemas(schema, out):
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$defs": {"Distribution": distribution_schema()}}
    quantity = {"anyOf": [{"$ref": "#/$defs/Distribution"}, {"type": "string"}]}
    head["$defs"] |= {"Numbers": {"type": "array", "items": quantity, "minItems": 2, "maxItems": 3},
                      **{name.rpartition(".")[2]: message_schema(schema, name) for name in OF_FILES}}
    scene = message_schema(schema, ".parallax.v1.SceneConfig")
    # A study's own words (common/config/study_loader.cc); `base` names a scene config that `set` is merged onto.
    said = study_meanings(schema)
    name, number, of_scene = {"type": "string"}, {"type": "integer", "minimum": 1}, {"$ref": "#/$defs/Scene"}
    seed = {"type": "integer", "minimum": 0}

    def described(prefix, properties):
        return {word: {**body, "description": said[prefix + word]} for word, body in properties.items()}

    variant = {"type": "object", "required": ["name"], "additionalProperties": False, "properties": {
        **described("variants[].", {"name": name, "base": name, "pairs": number, "rigs_per_scene": number, "seed": seed,
                                    "set": of_scene, "config": of_scene}),
        "heldout": {"type": "boolean", "description":
                    one_line(schema.comments[".parallax.v1.VariantSpec.heldout"]) + " Only in study.lock.yaml."}}}
    own = [{"required": ["study", "variants"]}, {"required": ["study", "search"]}, {"required": ["extends"]}]
    study = {"type": "object", "additionalProperties": False, "anyOf": own, "properties": described("", {
        "study": name, "extends": name, "base": name, "set": of_scene, "seed": seed,
        "pairs": {"anyOf": [number, {"enum": ["endless"]}]}, "rigs_per_scene": number, "priority": {"type": "integer"},
        "tags": {"type": "array", "items": name}, "memory_mb": {"type": "integer", "minimum": 0},
        "variants": {"type": "array", "items": variant, "minItems": 1},
        "stream": message_schema(schema, ".parallax.v1.StreamSpec"),
        "search": search_schema(schema),
        "notify": message_schema(schema, ".parallax.v1.NotifySpec"),
        "train": message_schema(schema, ".parallax.v1.TrainSpec"),
        "evaluate": message_schema(schema, ".parallax.v1.EvaluateSpec")})}
    biome, room = {"$ref": "#/$defs/Biome"}, {"$ref": "#/$defs/RoomKind"}
    engine = message_schema(schema, ".parallax.v1.Engine")
    for name, body, more in (("biome", biome, {}), ("room", room, {}), ("engine", engine, {}), ("scene", scene, {}), ("study", study, {"Scene": scene})):
        head["$defs"] |= more
        text = json.dumps({**head, "title": f"Parallax {name}", **body}, indent=1)
        (out / f"{name}.schema.json").write_text(text + "\n")


def help_of(command):
    run = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True)
    return run.stdout.rstrip()


# Headings in a program's --help under which its commands stand.
COMMAND_HEADINGS = ("On this machine:", "With a coordinator:", "Subcommands:", "Commands:")


def subcommands(text):
    """Names of the commands that a --help lists: the first words of indented lines below the headings."""
    names, inside = [], False
    for line in text.splitlines():
        if line and not line.startswith(" "):
            inside = line.strip() in COMMAND_HEADINGS
        elif inside and line.startswith("  ") and not line.startswith("   "):
            names.append(line.split()[0])
    return names


def sections(command, level):
    text = help_of(command)
    name = " ".join([pathlib.Path(command[0]).name, *command[1:]])
    yield from [f"{'#' * level} {name}", "", "```text", text, "```", ""]
    for child in subcommands(text):
        yield from sections([*command, child], min(level + 1, 4))


def write_commands_page(programs, out):
    lines = ["# Command reference", "", "What each program's `--help` says.", ""]
    for program in ("parallax", "worker", "coordinator"):
        lines += sections([str(programs / program)], 2)
    (out / "commands.md").write_text("\n".join(lines))


def main():
    args = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    args.add_argument("what", choices=("config", "commands"))
    args.add_argument("--proto", default="proto")
    args.add_argument("--bin", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    args.add_argument("--out", type=pathlib.Path, required=True)
    args = args.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    if args.what == "commands":
        write_commands_page(args.bin, args.out)
        return
    schema = Schema(*load_files(args.proto))
    write_config_page(schema, args.out)
    write_json_schemas(schema, args.out)
    if schema.without_meaning:
        sys.exit("reference: no comment in proto/parallax/v1 says what these fields mean: " +
                 ", ".join(dict.fromkeys(schema.without_meaning)))


if __name__ == "__main__":
    main()
