"""A cluster of Slurm on this machine, for tests: munge, one slurmctld and two slurmd, in a folder."""

import contextlib
import getpass
import os
import pathlib
import signal
import socket
import subprocess
import time

PATIENCE = 60.0  # [s]

CONF = """
ClusterName=clothsim
SlurmctldHost={host}({address})
SlurmctldPort={ctld_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool_%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd_%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd_%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0
SlurmdTimeout=5
MessageTimeout=3
ReturnToService=2
JobRequeue=0
MpiDefault=none
{nodes}
PartitionName=test Nodes=ALL Default=YES MaxTime=10 State=UP
"""


def free_port():
    with contextlib.closing(socket.socket()) as s:
        s.bind(("", 0))
        return s.getsockname()[1]


class Cluster:
    def __init__(self, folder, nodes=2):
        self.folder = pathlib.Path(folder)
        self.processes = {}
        host = socket.gethostname().split(".")[0]
        cores = os.cpu_count()
        lines = ["NodeName=node%d NodeHostname=%s NodeAddr=127.0.0.1 Port=%d CPUs=%d State=UNKNOWN"
                 % (i, host, free_port(), cores) for i in range(nodes)]
        (self.folder / "state").mkdir(parents=True)
        self.conf = self.folder / "slurm.conf"
        self.conf.write_text(CONF.format(host=host, address="127.0.0.1", ctld_port=free_port(),
                                         user=getpass.getuser(), folder=self.folder,
                                         nodes="\n".join(lines)))
        self.environment = {**os.environ, "SLURM_CONF": str(self.conf)}

    def start(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.folder.chmod(0o755)
        self.run("munged", "--foreground", "--force", "--socket=%s/munge.socket" % self.folder,
                 "--key-file=%s" % key, "--pid-file=%s/munged.pid" % self.folder,
                 "--log-file=%s/munged.log" % self.folder, "--seed-file=%s/munged.seed" % self.folder)
        self.wait(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.run("slurmctld", "-D", "-i")
        for node in ("node0", "node1"):
            self.start_node(node)
        self.wait(lambda: self.nodes().count("idle") == 2, "two nodes that are idle")

    def start_node(self, node):
        self.run("slurmd", "-D", "-N", node, name=node)

    def nodes(self):
        run = subprocess.run(["sinfo", "--noheader", "--Node", "--format=%t"], env=self.environment,
                             capture_output=True, text=True, check=False)
        return run.stdout.split()

    def run(self, program, *words, name=None):
        log = open(self.folder / ("%s.out" % (name or program)), "w")
        self.processes[name or program] = subprocess.Popen(
            ["/usr/sbin/" + program, *words], env=self.environment, stdin=subprocess.DEVNULL,
            stdout=log, stderr=subprocess.STDOUT)
        log.close()

    def wait(self, condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise AssertionError("waited %g s for %s\n%s" % (PATIENCE, what, self.logs()))
            time.sleep(0.1)

    def logs(self):
        return "\n".join("%s:\n%s" % (path.name, path.read_text(errors="replace")[-2000:])
                         for path in sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out")))

    def kill_node(self, node):
        """At once, with all its processes, as when a machine fails."""
        steps = subprocess.run(["pgrep", "-x", "slurmstepd"], capture_output=True, text=True,
                               check=False).stdout.split()
        daemon = self.processes.pop(node)
        daemon.kill()
        daemon.wait()
        for pid in map(int, steps):
            self.kill_tree_of_node(pid, node)

    def kill_tree_of_node(self, pid, node):
        """A step of this cluster's node, and its child processes."""
        try:
            environment = pathlib.Path("/proc/%d/environ" % pid).read_bytes()
        except OSError:
            return
        if str(self.conf).encode() not in environment:
            return
        family = descendants(pid)
        names = b"".join(read_environment(p) for p in family)
        if b"SLURMD_NODENAME=" + node.encode() in names:
            for p in [pid, *family]:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(p, signal.SIGKILL)

    def stop(self):
        for process in self.processes.values():
            process.terminate()
        for process in self.processes.values():
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def read_environment(pid):
    try:
        return pathlib.Path("/proc/%d/environ" % pid).read_bytes()
    except OSError:
        return b""


def descendants(pid):
    found = []
    with contextlib.suppress(OSError):
        for thread in os.listdir("/proc/%d/task" % pid):
            for child in pathlib.Path("/proc/%d/task/%s/children" % (pid, thread)).read_text().split():
                found += [int(child), *descendants(int(child))]
    return found
