#!/usr/bin/env python3
"""The JSON Schemas of configs take every built-in file and refuse mistakes.
Usage: schema_test.py SOURCE_DIR, with the environment of the documentation (jsonschema, PyYAML)."""
import copy
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import jsonschema
import yaml

SOURCE = pathlib.Path(sys.argv.pop())
SCHEMAS = {}


def setUpModule():
    with tempfile.TemporaryDirectory() as out:
        subprocess.run(["/usr/bin/python3", "-B", SOURCE / "deploy/site/make_reference.py", "config",
                        "--proto", SOURCE / "proto", "--out", out], check=True)
        for path in pathlib.Path(out).glob("*.schema.json"):
            SCHEMAS[path.name.split(".")[0]] = json.loads(path.read_text())


def schema(name):
    return SCHEMAS[name]


def load(path):
    return yaml.safe_load(path.read_text())


class SchemaTest(unittest.TestCase):
    def test_built_in_files_fit(self):
        files = sorted((SOURCE / "configs/scenes").glob("*.yaml"))
        self.assertGreaterEqual(len(files), 3)
        for path in files:
            jsonschema.validate(load(path), schema("scene"))
        files = sorted((SOURCE / "configs/biomes").glob("*.yaml"))
        self.assertEqual(len(files), 11)
        for path in files:
            jsonschema.validate(load(path), schema("biome"))
        files = sorted((SOURCE / "configs/rooms").glob("*.yaml"))
        self.assertEqual(len(files), 13)
        for path in files:
            jsonschema.validate(load(path), schema("room"))
        files = sorted((SOURCE / "configs/engines").glob("*.yaml"))
        self.assertEqual(len(files), 3)
        for path in files:
            jsonschema.validate(load(path), schema("engine"))
        files = sorted((SOURCE / "configs/studies").glob("*.yaml"))
        self.assertGreaterEqual(len(files), 7)
        for path in files:
            with self.subTest(path.name):
                jsonschema.validate(load(path), schema("study"))

    def test_the_variant_that_a_lock_file_holds_out_fits(self):
        study = load(SOURCE / "configs/studies/quickstart.yaml")
        study["variants"].append({"name": "heldout", "seed": 2, "pairs": 40, "heldout": True})
        jsonschema.validate(study, schema("study"))
        study["variants"][-1]["heldout"] = 1
        with self.assertRaises(jsonschema.ValidationError):
            jsonschema.validate(study, schema("study"))

    def test_a_land_of_the_users_own_has_a_weight_by_its_name(self):
        scene = {"type": "nature", "nature": {"biome_files": ["my_heath.yaml"], "biomes": {"my_heath": 1}}}
        jsonschema.validate(scene, schema("scene"))
        scene["nature"]["biomes"]["my_heath"] = "often"
        with self.assertRaises(jsonschema.ValidationError):
            jsonschema.validate(scene, schema("scene"))

    def test_mistakes_do_not_fit(self):
        good = load(SOURCE / "configs/studies/quickstart.yaml")
        jsonschema.validate(good, schema("study"))
        for wrong in ({"pairs": "many"}, {"variants": []}, {"varients": []},
                      {"variants": [{"name": "a", "set": {"rigs": {"baseline": 1}}}]},
                      {"variants": [{"name": "a", "set": {"rigs": {"width_px": 4}}}]},
                      {"variants": [{"name": "a", "set": {"solver": {"mode": "fast"}}}]},
                      {"train": {"seeds": 0}}):
            study = copy.deepcopy(good)
            study.update(wrong)
            with self.subTest(wrong), self.assertRaises(jsonschema.ValidationError):
                jsonschema.validate(study, schema("study"))


if __name__ == "__main__":
    unittest.main()
