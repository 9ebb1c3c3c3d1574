"""The Python client against a farm with certificates, as the program `parallax` sees the same farm: the same statuses, and of
every failure the same words and the same code.

python_client_test.py BIN TREE: BIN is the folder of the programs, TREE the repository."""

import contextlib
import dataclasses
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import types
import unittest
from pathlib import Path
from unittest import mock

BIN, TREE = (Path(argument).resolve() for argument in (sys.argv.pop(1), sys.argv.pop(1)))
sys.path.insert(0, str(TREE / "common/python/parallax_data"))
os.environ["PATH"] = f"{BIN}:{os.environ['PATH']}"
for variable in ("PARALLAX_COORDINATOR", "PARALLAX_TLS"):
    os.environ.pop(variable, None)

from parallax_data import Client, ParallaxDataset, ParallaxError, client as client_module  # noqa: E402

PAIRS = """
seed: 5
pairs: 2
rigs_per_scene: 2
set:
  floating: {count: 2}
  rigs: {count: 4, width_px: 64, height_px: 48}
  render: {profile: preview, samples_per_pixel: 1}
  filters: {min_mean_intensity: 0, min_depth_m: 0}
"""
TINY = "study: tiny\nbase: indoor" + PAIRS + """
variants:
  - {name: narrow, set: {rigs: {baseline_m: 0.06}}}
  - {name: wide, set: {rigs: {baseline_m: 0.2}}}
train: {trainer: script, steps: 2, seeds: 2, threads: 1}
evaluate: {heldout_pairs: 1}
"""
NEVER = "study: never\nbase: indoor" + PAIRS + "tags: [no-worker-has-it]\nvariants: [{name: v}]\n"
PATIENCE_S = 60


class Farm:
    """Processes of one test class, with a folder of their own."""

    def __init__(self):
        self.folder = Path(tempfile.mkdtemp(prefix="parallax-python-"))
        self.processes = []

    def start(self, *command):
        """Starts a daemon; its standard output is a pipe."""
        with open(self.folder / f"{len(self.processes)}.log", "w") as log:
            self.processes.append(subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, stderr=log, text=True,
                                                   cwd=self.folder))
        return self.processes[-1]

    def serve(self, *more, listen="127.0.0.1:0"):
        """Starts a coordinator; returns its process and its address."""
        process = self.start(BIN / "coordinator", "serve", "--db", "queue.db", "--store", "store", "--http", "", "--listen", listen,
                             *more)
        line = process.stdout.readline()
        assert line.startswith("listening on "), line + (self.folder / f"{len(self.processes) - 1}.log").read_text()
        return process, line.removeprefix("listening on ").strip()

    def stop(self):
        for process in reversed(self.processes):
            end(process)
        shutil.rmtree(self.folder)


def end(process):
    process.send_signal(signal.SIGTERM)
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()


def said(*arguments):
    """Exit code and output of `parallax`, and its error without "error: "."""
    done = subprocess.run([BIN / "parallax", *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=PATIENCE_S)
    return done.returncode, done.stdout, done.stderr.removeprefix("error: ").strip()


def as_json(status):
    """A status as the program prints it: jobs of a variant under their kinds."""
    entry = dataclasses.asdict(status)
    for variant in entry.get("variants", ()):
        jobs = variant.pop("jobs")
        variant.update({f"{kind}_jobs": jobs.get(kind, {}) for kind in {"solve", "render", "train", "evaluate"} | set(jobs)})
    if "variants" in entry:
        entry["variant_count"] = len(entry["variants"])
    return entry


class SecureFarm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.farm = Farm()
        cls.addClassCleanup(cls.farm.stop)
        folder = cls.farm.folder
        for tls in ("tls", "other"):
            subprocess.run([BIN / "coordinator", "init", folder / tls, "--issue", "worker", "pool", "--issue", "submitter", "ada",
                            "--issue", "read-only", "board"], check=True, stdout=subprocess.DEVNULL)
        cls.tls = folder / "tls/submitter-ada"
        cls.coordinator, cls.address = cls.farm.serve("--tls", folder / "tls/server")
        (folder / "trainers").mkdir()
        script = f"{sys.executable}, -B, {TREE}/tests/worker/jobs/script_trainer.py"
        (folder / "trainers/script.yaml").write_text(
            f"trainer: script\nlayout: archive\nprogress: json\nleaves: {{checkpoints: net-*.json, final: last.json}}\n"
            f"train: [{script}, train, '--data={{data}}={{weight}}', --out, '{{out}}', --seed, '{{seed}}', --steps, '{{steps}}',"
            " --every, '{checkpoint_every}']\n"
            f"predict: [{script}, predict, --checkpoint, '{{checkpoint}}', --list, '{{list}}']\n")
        cls.farm.start(BIN / "worker", "--role", "all", "--coordinator", cls.address, "--tls", folder / "tls/worker-pool", "--name",
                       "w", "--outbox", "outbox", "--cache", "cache", "--cores-dir", "cores", "--trainers", "trainers",
                       "--allow-trainers", "script")
        cls.client = Client(cls.address, cls.tls)
        cls.addClassCleanup(cls.client.close)
        cls.file = folder / "tiny.yaml"
        cls.file.write_text(TINY)
        cls.submitted = cls.client.submit(cls.file)
        cls.statuses = list(cls.client.follow(cls.submitted))

    def said(self, *arguments, address=None, tls=None):
        where = ["--coordinator", self.address if address is None else address]
        tls = self.tls if tls is None else tls
        return said(*arguments, *where, *(["--tls", tls] if tls else []))

    def printed(self, *arguments):
        code, out, error = self.said(*arguments, "--json")
        self.assertEqual(code, 0, error)
        return json.loads(out)

    def expect_the_same_error(self, call, *arguments, address=None, tls=None):
        code, _, words = self.said(*arguments, address=address, tls=tls)
        self.assertNotEqual(code, 0, arguments)
        with self.assertRaises(ParallaxError, msg=arguments) as raised:
            call()
        self.assertEqual(str(raised.exception), words)
        self.assertEqual(raised.exception.code, code, words)
        return words

    def test_a_study_is_followed_to_its_end(self):
        self.assertFalse(self.submitted.existed)
        self.assertEqual(self.submitted.pairs_wanted, 5)
        last = self.statuses[-1]
        self.assertEqual((last.state, last.pairs_done, last.finished), ("succeeded", 5, True))
        self.assertGreater(len(self.statuses), 2)
        done = [status.pairs_done for status in self.statuses]
        self.assertEqual(done, sorted(done))
        self.assertFalse(any(status.finished for status in self.statuses[:-1]))
        self.assertEqual(last.jobs("succeeded")["train"], 4)

    def test_statuses_are_those_that_the_program_prints(self):
        study = self.client.status("tiny")
        self.assertEqual(as_json(study), self.printed("status", "tiny"))
        self.assertEqual(self.client.status(study.study_id), study)
        listed = {one.study_id: as_json(one) for one in self.client.studies()}
        for printed in self.printed("status")["studies"]:
            self.assertEqual(listed[printed["study_id"]], printed)
        jobs = [dataclasses.asdict(job) for job in self.client.jobs("tiny")]
        self.assertEqual(jobs, self.printed("jobs", "tiny", "--all")["jobs"])
        self.assertEqual([job.job_id for job in self.client.jobs(study, limit=2)], [job["job_id"] for job in jobs[:2]])
        self.assertEqual(len(self.client.jobs(study, state="succeeded")), len(jobs))
        self.assertEqual(self.client.jobs(study, state="failed"), [])
        job = next(job for job in jobs if job["kind"] == "train")["job_id"]
        attempts = [dataclasses.asdict(attempt) for attempt in self.client.attempts(job)]
        self.assertEqual(attempts, self.printed("logs", job)["attempts"])
        self.assertEqual(attempts[0]["ending"], "succeeded")
        workers = [dataclasses.asdict(worker) for worker in self.client.workers()]
        printed = self.printed("workers")["workers"]
        for worker in [*workers, *printed]:
            self.assertLess(worker.pop("last_heard_s"), PATIENCE_S)
        self.assertEqual(workers, printed)

    def test_what_is_fetched_is_a_dataset(self):
        out = self.farm.folder / "out"
        fetched = self.client.fetch("tiny", out)
        self.assertEqual((fetched.frames, fetched.frames_added, fetched.trainings), (5, 5, 4))
        self.assertEqual(self.client.fetch(self.submitted, str(out)).frames_present, 5)
        data = ParallaxDataset(out)
        self.assertEqual(len(data), 4)
        self.assertEqual(data[0].left.shape, (48, 64, 3))

    def test_the_table_has_a_row_a_figure(self):
        for pandas in (False, True):
            # Where pandas is missing, a module of that name shows what it would be given.
            module = types.SimpleNamespace(DataFrame=lambda rows: rows) if pandas else None
            with mock.patch.dict(sys.modules, {"pandas": module}):
                rows = self.client.table("tiny", baseline="wide")
            printed = self.printed("table", "tiny", "--baseline", "wide")
            cells = {(row["variant"], name): cell for row in printed["rows"] for name, cell in row["benchmarks"].items()}
            compared = {one["variant"]: one for one in printed["comparisons"]}
            self.assertEqual(len(rows), sum(1 + len(cell["others"]) for cell in cells.values()))
            heads = {row["variant"]: row for row in rows if row["metric"] == cells["narrow", row["benchmark"]]["metric"]}
            self.assertEqual(set(heads), {variant for variant, _ in cells})
            self.assertEqual(heads["narrow"]["value"], cells["narrow", "heldout"]["value"])
            self.assertEqual(heads["narrow"]["verdict"], compared["narrow"]["verdict"])
            self.assertEqual(heads["narrow"]["baseline"], "wide")
            self.assertIsNone(heads["wide"]["verdict"])

    def test_a_study_may_be_a_text_or_a_dict(self):
        _, out, _ = said("plan", self.file, "--json", "--cores", "3")
        self.assertEqual(self.client.plan(TINY, cores=3), json.loads(out.replace(str(self.file), "<study>")))
        self.assertEqual(self.client.plan({"study": "one", "base": "indoor", "pairs": 7, "variants": [{"name": "v"}]})["total"]["pairs"], 7)
        again = self.client.submit(TINY)
        self.assertEqual((again.study_id, again.existed, again.state), (self.submitted.study_id, True, "succeeded"))
        with self.assertRaisesRegex(ParallaxError, "<study>:2: pears: no such field, did you mean pairs"):
            self.client.submit("study: x\npears: 3\n")
        self.assertEqual(list(Path().glob(".parallax-study-*")), [])

    def test_a_person_steers_a_study(self):
        study = self.client.submit(NEVER, name="steered", priority=3)
        waiting = [(one.kind, one.reason) for one in study.unservable]
        self.assertIn(("solve", "tag"), waiting)
        self.expect_the_same_error(lambda: self.client.forget("steered"), "forget", "steered", "--yes")
        self.assertEqual(self.client.pause("steered", reason="lunch").state, "paused")
        self.assertEqual(self.client.resume(study).state, "running")
        self.assertEqual(self.client.retry(study), 0)
        self.assertEqual(self.client.cancel(study.study_id).state, "cancelled")
        self.expect_the_same_error(lambda: self.client.resume("steered"), "resume", "steered")
        self.assertEqual(self.client.forget("steered").jobs, 1)
        self.expect_the_same_error(lambda: self.client.status("steered"), "status", "steered")

    def test_errors_have_the_words_of_the_program(self):
        bad = self.farm.folder / "bad.yaml"
        bad.write_text("study: bad\nbase: indoor\npears: 4\nvariants: [{name: v, set: {rigs: {count: -3}}}]\n")
        client = self.client
        for call, arguments in (
                (lambda: client.status("nobody"), ("status", "nobody")),
                (lambda: client.status(4711), ("status", "4711")),
                (lambda: client.status("0"), ("status", "0")),
                (lambda: client.fetch("nobody", "x"), ("fetch", "nobody", "--out", "x")),
                (lambda: client.table("nobody"), ("table", "nobody")),
                (lambda: client.attempts(999999), ("logs", "999999")),
                (lambda: client.submit(bad), ("submit", bad)),
                (lambda: client.submit("no-such-study"), ("submit", "no-such-study")),
                (lambda: client.submit(self.file, pears=3), ("submit", self.file, "--pears", "3")),
                (lambda: client.plan(bad), ("plan", bad)),
                (lambda: client.pause("tiny", reason="two\nlines"), ("pause", "tiny", "--reason", "two\nlines"))):
            self.expect_the_same_error(call, *arguments)
        read_only = Client(self.address, self.farm.folder / "tls/read-only-board")
        self.addCleanup(read_only.close)
        words = self.expect_the_same_error(lambda: read_only.cancel("tiny"), "cancel", "tiny", tls=read_only.tls)
        self.assertIn("role", words)

    def test_failed_connections_have_the_words_of_the_program(self):
        folder = self.farm.folder
        for name, files in (("mixed", {"tls.key": (folder / "other/submitter-ada/tls.key").read_text()}),
                            ("garbage", {"ca.crt": "no certificate\n", "tls.crt": "nor here\n", "tls.key": "no key\n"})):
            shutil.copytree(self.tls, folder / name)
            for file, text in files.items():
                (folder / name / file).write_text(text)
        for address, tls, words in (
                (self.address, folder / "mixed", "is not the key"),
                (self.address, folder / "garbage", "not a certificate"),
                (self.address, folder / "other/submitter-ada", "did not sign"),
                (self.address, "", "speaks TLS"),
                (self.address, folder / "nothing", "no such file"),
                (self.address.replace("127.0.0.1", "localhost") + "1", self.tls, "port"),
                ("127.0.0.1", "", "no port"),
                ("192.0.2.1:7070", "", "is not of this machine"),
                ("unix:there", "", "not absolute"),
                ("unix:/nowhere/socket", "", "no coordinator at unix:/nowhere/socket: No such file or directory"),
                ("127.0.0.1:1", "", "no coordinator at 127.0.0.1:1: Connection refused")):
            with Client(address, tls) as client:
                seen = self.expect_the_same_error(client.studies, "status", address=address, tls=tls)
            self.assertRegex(seen.lower(), words.lower())

    def test_without_the_program_studies_are_read_and_steered(self):
        with mock.patch.object(client_module, "_program", return_value=None):
            with Client(self.address, self.tls) as client:
                self.assertEqual(client.status("tiny").state, "succeeded")
                for call in (lambda: client.submit(TINY), lambda: client.fetch("tiny", "x"), lambda: client.table("tiny")):
                    with self.assertRaisesRegex(ParallaxError, "needs the program parallax"):
                        call()
            for address in ("127.0.0.1:1", "unix:/nowhere/socket", "192.0.2.1:7070"):
                with Client(address, tls="") as client:
                    self.expect_the_same_error(client.studies, "status", address=address, tls="")

    def test_the_environment_names_the_coordinator(self):
        with mock.patch.dict(os.environ, {"PARALLAX_COORDINATOR": self.address, "PARALLAX_TLS": str(self.tls)}):
            with Client() as client:
                self.assertEqual(client.status("tiny").name, "tiny")
        self.assertEqual(repr(Client()), "Client('127.0.0.1:7070')")


class Wheel(unittest.TestCase):
    """The package as the wheel has it: no clone around it, no protoc, and the program beside it."""

    def test_the_wheel_has_program_and_descriptors(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "tree/bin").mkdir(parents=True)
            (folder / "tree/share/doc/parallax").mkdir(parents=True)
            (folder / "tree/share/doc/parallax/README.md").write_text("Parallax\n")
            (folder / "tree/bin/parallax").write_text(f"#!/bin/sh\nexec {BIN}/parallax \"$@\"\n")
            wheel = subprocess.run(
                [sys.executable, "-B", TREE / "deploy/package/make_wheel.py", "--tree", folder / "tree", "--out", folder, "--name",
                 "parallax-stereo", "--version", "1.2.3", "--tag", "any", "--data", TREE / "common/python/parallax_data/parallax_data"],
                check=True, capture_output=True, text=True).stdout.strip()
            subprocess.run(["unzip", "-q", wheel, "-d", folder / "site"], check=True)
            script = ("import parallax_data as p; print(p.__file__); print(p.Client().plan('quickstart')['name'])\n"
                      "try: p.Client('unix:/nowhere/socket').studies()\n"
                      "except p.ParallaxError as error: print(error)")
            done = subprocess.run([sys.executable, "-B", "-c", script], capture_output=True, text=True, cwd=folder,
                                  env={"PYTHONPATH": str(folder / "site"), "PATH": "/nowhere", "HOME": name})
            lines = done.stdout.splitlines()
            self.assertEqual(lines[:2], [f"{folder}/site/parallax_data/__init__.py", "quickstart"], done.stderr)
            self.assertIn("no coordinator at unix:/nowhere/socket", lines[2])


class Watching(unittest.TestCase):
    """A coordinator without workers, on a socket."""

    def setUp(self):
        self.farm = Farm()
        self.addCleanup(self.farm.stop)
        self.listen = f"unix:{self.farm.folder}/socket"
        self.coordinator, _ = self.farm.serve(listen=self.listen)
        self.client = Client(self.listen)
        self.addCleanup(self.client.close)
        self.study = self.client.submit(NEVER)

    def test_a_coordinator_that_restarts_is_waited_for(self):
        seen, first = [], threading.Event()

        def follow():
            for status in self.client.follow(self.study, poll_s=0.05):
                seen.append(status.state)
                first.set()

        thread = threading.Thread(target=follow)
        thread.start()
        self.assertTrue(first.wait(PATIENCE_S))
        end(self.coordinator)
        self.farm.processes.remove(self.coordinator)
        self.coordinator, _ = self.farm.serve(listen=self.listen)
        self.assertEqual(said("cancel", "never", "--coordinator", self.listen)[0], 0)
        thread.join(PATIENCE_S)
        self.assertFalse(thread.is_alive())
        self.assertEqual((seen[0], seen[-1]), ("running", "cancelled"))

    def test_watching_shows_a_bar_or_a_line(self):
        self.client.cancel(self.study)
        bar = mock.MagicMock()
        with mock.patch.dict(sys.modules, {"tqdm": mock.MagicMock(), "tqdm.auto": bar}):
            self.assertEqual(self.client.watch("never").state, "cancelled")
        bar.tqdm.assert_called_once_with(desc="never", total=2, initial=0, unit="pair")
        bar.tqdm.return_value.set_postfix_str.assert_called_once_with("cancelled")
        bar.tqdm.return_value.close.assert_called_once_with()
        with mock.patch.dict(sys.modules, {"tqdm": None, "tqdm.auto": None}), contextlib.redirect_stderr(io.StringIO()) as line:
            self.client.watch(self.study)
        self.assertEqual(line.getvalue(), "\rnever: 0/2 pairs, cancelled\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
