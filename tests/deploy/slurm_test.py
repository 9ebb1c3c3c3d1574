#!/usr/bin/env python3
"""deploy/slurm/workers.sbatch and `parallax farm slurm` in a real Slurm of one node, with the real programs.

slurm_test.py SOURCE_DIR BIN_DIR [SCENARIO...]    all scenarios take nine minutes; status 77: nothing was tried, as there is
                                                  no Slurm here, or the scenario is "asked" and PARALLAX_TEST_SLURM is not set

Each scenario prints one line with its figures."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import slurm_cluster  # noqa: E402

SOURCE, BIN = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
SCRIPT = SOURCE / "deploy/slurm/workers.sbatch"
PILOT = ("--cpus-per-task=2", "--mem=3000")


class Farm:
    """A coordinator and a Slurm cluster; studies of small pairs."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.cluster = slurm_cluster.SlurmCluster(self.folder / "slurm")
        self.address = f"127.0.0.1:{slurm_cluster.free_port()}"
        self.cluster.env |= {
            "PARALLAX_COORDINATOR": self.address, "PARALLAX_WORKER": str(BIN / "worker"), "PARALLAX_TLS": "",
            "PARALLAX_STATE": str(self.folder / "state"), "PARALLAX_IDLE": "30"}

    def start(self):
        self.cluster.start()
        self.log = open(self.folder / "coordinator.log", "w")
        self.coordinator = subprocess.Popen(
            [BIN / "coordinator", "serve", "--db", self.folder / "queue.db", "--store", self.folder / "store", "--listen",
             self.address], stdout=self.log, stderr=self.log, preexec_fn=slurm_cluster.die_with_parent)
        self.wait("the coordinator", lambda: self.client("status", "--json", check=False))

    def stop(self):
        self.cluster.stop()
        if hasattr(self, "coordinator"):
            self.coordinator.terminate()
            self.coordinator.wait(30)

    def wait(self, what, condition, seconds=90):
        return self.cluster.wait(what, condition, seconds)

    def client(self, *arguments, check=True):
        return self.cluster.run(str(BIN / "parallax"), *arguments, check=check)

    def submit(self, name, pairs, rigs, width):
        return self.client("submit", "quickstart", "--name", name, "--pairs", str(pairs), "--rigs", str(rigs), "--width",
                           str(width), "--height", str(width * 3 // 4), "--profile", "preview").strip()

    def jobs(self, study):
        return json.loads(self.client("jobs", study, "--limit", "1000", "--json"))["jobs"]

    def succeeded(self, study):
        return all(job["state"] in ("succeeded", "rejected") for job in self.jobs(study))

    def leased(self, study, kind):
        return [job for job in self.jobs(study) if job["state"] == "leased" and job["kind"] == kind]

    def pilot(self, *options):
        """Submits one pilot by hand; its job's id."""
        return self.cluster.run("sbatch", "--parsable", "--array=1-1", f"--output={self.folder}/pilot-%A_%a.log", *PILOT,
                                *options, str(SCRIPT)).strip().split(";")[0]

    def pilot_log(self, job):
        path = self.folder / f"pilot-{job}_1.log"
        return path.read_text() if path.exists() else ""

    def taken_over(self, job):
        """Pairs of earlier attempts that a pilot's worker went on from."""
        return sum(int(n) for n in re.findall(r"pairs of earlier attempts are taken over.*?pairs=(\d+)", self.pilot_log(job)))

    def notes(self):
        """Files that tell of a finished pair of a job."""
        return set((self.folder / "store").glob("*/*/.attempt-*/finished/*.pb"))

    def queued(self, job):
        return [task for task in self.cluster.queue() if task[0].startswith(job + "_")]


def require(condition, message):
    if not condition:
        raise AssertionError(message)


def follows_demand(farm):
    """From no pilot to three and back to none; a pilot that Slurm kills is replaced."""
    before = farm.cluster.queue()
    require(not before, f"pilots before there is work: {before}")
    study = farm.submit("demand", pairs=32, rigs=4, width=256)
    log = open(farm.folder / "farm.log", "w+")
    keeper = subprocess.Popen(
        [BIN / "parallax", "farm", "slurm", "--max", "3", "--script", SCRIPT, "--interval", "2", "--idle", "30",
         "--until-done", *(f"--sbatch={option}" for option in PILOT), f"--sbatch=--output={farm.folder}/farm-%A_%a.log"],
        env=farm.cluster.env, stdout=log, stderr=log, preexec_fn=slurm_cluster.die_with_parent)
    try:
        seen = farm.wait("three pilots", lambda: len([t for t in farm.cluster.queue() if t[1] == "RUNNING"]) == 3 and
                         farm.cluster.queue())
        farm.wait("work in the pilots", lambda: farm.leased(study, "render"))
        killed = seen[0][0]
        farm.cluster.run("scancel", "--signal=KILL", "--full", killed)
        farm.wait("another pilot in its place", lambda: len({t[0] for t in farm.cluster.queue() if t[1] == "RUNNING"} -
                                                          {killed}) == 3, 60)
        farm.wait("the study's end", lambda: farm.succeeded(study), 240)
        ended = time.monotonic()
        farm.wait("no pilot", lambda: not farm.cluster.queue(), 120)
        idle_s = time.monotonic() - ended
        require(keeper.wait(30) == 0, f"farm slurm ended with {keeper.returncode}")
    finally:
        keeper.kill()
        keeper.wait()
        log.seek(0)
        said = log.read()
        print(said, end="")
    require(said.count("submitted") >= 2, "the killed pilot was not replaced")
    return f"0 -> 3 -> 0 pilots; {killed} killed and replaced; the last one gone {idle_s:.0f} s after the work"


def scancel(farm):
    """The worker ends by itself before Slurm kills it; its job is there for others at once, with the pairs it has."""
    study = farm.submit("scancel", pairs=10, rigs=10, width=1024)
    job = farm.pilot()
    before = farm.wait("a job that renders", lambda: [j for j in farm.leased(study, "render") if j["fraction"] > 0.3], 120)[0]
    start = time.monotonic()
    farm.cluster.run("scancel", job)
    farm.wait("the pilot's end", lambda: not farm.queued(job), 60)
    gone_s = time.monotonic() - start
    require(gone_s < 28, f"the worker was killed: {gone_s:.0f} s")
    log = farm.pilot_log(job)
    require("draining" in log, f"no drain in the log: {log[-2000:]}")
    after = [j for j in farm.jobs(study) if j["kind"] == "render"]
    require(not [j for j in after if j["state"] == "leased"], "a lease is left")
    kept = sum(len(j["rigs"]) for j in after if j["state"] == "succeeded")
    second = farm.pilot()
    farm.wait("the study's end", lambda: farm.succeeded(study), 240)
    farm.cluster.run("scancel", second)
    farm.wait("the second pilot's end", lambda: not farm.queued(second), 60)
    kept += farm.taken_over(second)
    finished = int(before["fraction"] * len(before["rigs"]))
    require(kept >= finished >= 3, f"{kept} of the {finished} pairs that were finished at {before['fraction']:.0%} of the job are kept")
    return (f"gone in {gone_s:.1f} s at {before['fraction']:.0%} of a job of {len(before['rigs'])} pairs; {kept} pairs kept; "
            "another pilot finished the study")


def killed(farm):
    """Slurm kills the pilot in the middle of a job, without a word: the pair in hand is lost, and no other."""
    before = farm.notes()
    study = farm.submit("killed", pairs=12, rigs=12, width=1280)
    job = farm.pilot()
    farm.wait("three finished pairs", lambda: len(farm.notes() - before) >= 3, 120)
    farm.cluster.run("scancel", "--signal=KILL", "--full", f"{job}_1")
    farm.wait("the pilot's end", lambda: not farm.queued(job), 60)
    finished = len(farm.notes() - before)
    require(finished < 12, "it was too quick")
    second = farm.pilot()
    farm.wait("the study's end", lambda: farm.succeeded(study), 300)
    farm.cluster.run("scancel", second)
    farm.wait("the second pilot's end", lambda: not farm.queued(second), 60)
    kept = farm.taken_over(second)
    require(kept == finished, f"{kept} of {finished} finished pairs are kept")
    return f"{kept} of the {finished} pairs that were finished when it died are kept"


def preemption(farm):
    """A pilot that is preempted hands its job back, comes back by itself under the same name and finishes the study."""
    study = farm.submit("preemption", pairs=6, rigs=6, width=384)
    job = farm.pilot("--partition=low", f"--cpus-per-task={slurm_cluster.CPUS}")
    farm.wait("a lease", lambda: farm.leased(study, "render") or farm.leased(study, "solve"), 60)
    urgent = farm.cluster.run("sbatch", "--parsable", "--partition=high", f"--cpus-per-task={slurm_cluster.CPUS}",
                              "--mem=3000", f"--output={farm.folder}/urgent.log", "--wrap=sleep 3").strip()
    farm.wait("the urgent job", lambda: any(t[0] == urgent and t[1] == "RUNNING" for t in farm.cluster.queue()), 60)
    # A requeued job waits two minutes; scontrol shortens that.
    waiting = farm.wait("the pilot in the queue", lambda: [t for t in farm.queued(job) if t[1] == "PENDING"], 60)
    farm.wait("the urgent job's end", lambda: not any(t[0] == urgent for t in farm.cluster.queue()), 60)
    farm.cluster.run("scontrol", "update", f"jobid={job}_1", "starttime=now", check=False)
    farm.wait("the study's end", lambda: farm.succeeded(study), 300)
    log = farm.pilot_log(job)
    require(log.count("connected") >= 2, f"one start only: {log[-2000:]}")
    farm.cluster.run("scancel", job)
    farm.wait("the pilot's end", lambda: not farm.queued(job), 60)
    return f"requeued ({waiting[0][2]}), came back and finished the study"


def time_limit(farm):
    """SIGUSR1 before the end of time: nothing new is begun, and the pilot ends by itself."""
    study = farm.submit("time", pairs=400, rigs=4, width=256)
    start = time.monotonic()
    job = farm.pilot("--time=2", "--signal=B:USR1@60")
    farm.wait("a lease", lambda: farm.leased(study, "render") or farm.leased(study, "solve"), 60)
    farm.wait("the pilot's end", lambda: not farm.queued(job), 170)
    lasted_s = time.monotonic() - start
    log = farm.pilot_log(job)
    require("TIME LIMIT" not in log and "CANCELLED" not in log, f"Slurm ended it: {log[-2000:]}")
    require("draining" in log, f"no drain: {log[-2000:]}")
    states = {j["state"] for j in farm.jobs(study)}
    require("leased" not in states, "a lease is left")
    farm.client("cancel", study)
    return f"ended by itself {lasted_s:.0f} s after its start of at most 120"


SCENARIOS = {"follows_demand": follows_demand, "scancel": scancel, "killed": killed, "preemption": preemption, "time_limit": time_limit}


def main():
    reason = slurm_cluster.missing()
    if "asked" in sys.argv[3:] and not os.environ.get("PARALLAX_TEST_SLURM"):
        reason = "takes nine minutes: PARALLAX_TEST_SLURM=1 runs it" + (f"; {reason}" if reason else "")
    if reason:
        print(f"SKIPPED: {reason}")
        return 77
    chosen = [name for name in sys.argv[3:] if name != "asked"] or list(SCENARIOS)
    folder = tempfile.mkdtemp(prefix="parallax_slurm_")
    farm = Farm(folder)
    failed = False
    try:
        farm.start()
        for name in chosen:
            start = time.monotonic()
            figures = SCENARIOS[name](farm)
            print(f"{name}: {figures} ({time.monotonic() - start:.0f} s)", flush=True)
    except (AssertionError, TimeoutError, RuntimeError) as error:
        failed = True
        print(f"FAILED: {error}\nfiles are in {folder}")
    finally:
        farm.stop()
    if not failed:
        shutil.rmtree(folder, ignore_errors=True)
    return 1 if failed else 0


sys.exit(main())
