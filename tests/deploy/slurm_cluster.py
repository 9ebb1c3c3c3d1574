"""A Slurm cluster of one node for tests: munged, slurmctld and slurmd on loopback, with all their files in one folder.

Needs Debian's slurmctld, slurmd, slurm-client and munge, and root (slurmd starts jobs). The daemons run in the
foreground as children of the test, end by their process ids with `stop`, and die with the test if it is killed."""

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")
CPUS = 8  # More than the machine has: what is tested is who runs when.

CONFIG = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmctldPort={control_port}
SlurmdPort={node_port}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
MpiDefault=none
ReturnToService=2
KillWait=30
MinJobAge=10
SchedulerParameters=sched_interval=1,bf_interval=1
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=16000 State=UNKNOWN
PartitionName=low Nodes=ALL Default=YES PriorityTier=1 PreemptMode=REQUEUE MaxTime=INFINITE State=UP
PartitionName=high Nodes=ALL PriorityTier=10 PreemptMode=OFF MaxTime=INFINITE State=UP
"""


def missing():
    """Why no cluster can be started here, "" if one can."""
    absent = [name for name in PROGRAMS if not shutil.which(name, path=search_path())]
    if absent:
        return f"no {', '.join(absent)}: apt-get install slurmctld slurmd slurm-client munge"
    return "" if os.geteuid() == 0 else "slurmd needs root"


def search_path():
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class SlurmCluster:
    def __init__(self, folder):
        self.folder = Path(folder)
        self.children = []
        self.env = dict(os.environ, PATH=search_path(), SLURM_CONF=str(self.folder / "slurm.conf"))
        for name in ("state", "spool"):
            (self.folder / name).mkdir(parents=True)
        # munged wants folders that nobody else can write.
        self.folder.chmod(0o755)
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        (self.folder / "slurm.conf").write_text(CONFIG.format(
            host=socket.gethostname().split(".")[0], folder=self.folder, control_port=free_port(), node_port=free_port(),
            cpus=CPUS))

    def start(self):
        folder = self.folder
        self._child("munged", "--foreground", "--force", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
                    f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/munged.seed")
        self.wait("munged's socket", lambda: (folder / "munge.socket").exists())
        self._child("slurmctld", "-D", "-c", "-f", str(folder / "slurm.conf"))
        self._child("slurmd", "-D", "-f", str(folder / "slurm.conf"))
        self.wait("an idle node", lambda: "idle" in self.run("sinfo", "--noheader", "--format=%t", check=False))

    def _child(self, *command):
        with open(self.folder / f"{command[0]}.out", "w") as output:
            self.children.append(subprocess.Popen(command, env=self.env, stdout=output, stderr=output,
                                                  preexec_fn=die_with_parent))

    def stop(self):
        """Cancels what runs, then ends the daemons, the last one first."""
        try:
            self.run("scancel", "--me", "--signal=KILL", "--full", check=False)
            self.run("scancel", "--me", check=False)
            self.wait("no job", lambda: not self.queue(), 40)
        except (TimeoutError, subprocess.SubprocessError):
            pass
        for child in reversed(self.children):
            child.terminate()
            try:
                child.wait(20)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()

    def run(self, *command, check=True, env=None):
        done = subprocess.run(command, env={**self.env, **(env or {})}, capture_output=True, text=True, timeout=60)
        if check and done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: status {done.returncode}: {done.stderr.strip()}")
        return done.stdout

    def queue(self, *options):
        """[(id, state, reason)] of array tasks that are not over."""
        lines = self.run("squeue", "--array", "--noheader", "--format=%i|%T|%r", *options).splitlines()
        return [tuple(line.split("|", 2)) for line in lines]

    def wait(self, what, condition, seconds=60):
        """The condition's value once it is true. Raises TimeoutError, naming `what`, after `seconds`."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            dead = [child.args[0] for child in self.children if child.poll() is not None]
            if dead:
                raise RuntimeError(f"{dead[0]} ended: {(self.folder / (dead[0] + '.out')).read_text()[-2000:]}")
            value = condition()
            if value:
                return value
            time.sleep(0.3)
        raise TimeoutError(f"waited {seconds} s for {what}")
