"""Runs cases as job arrays of Slurm: submits and follows them, and submits lost cases again."""

import json
import shlex
import subprocess
import sys
import time

from sweeping.cases import write_whole

# Largest number of submissions of a case that is lost by failing nodes or the time limit.
MOST_ROUNDS = 5

# Slurm's default MaxArraySize, if scontrol does not report it.
USUAL_ARRAY = 1001

# Consecutive failures of squeue that are tolerated, as while the controller restarts.
PATIENCE = 30


def call(*words):
    try:
        run = subprocess.run(words, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise SystemExit("sweep: %s is not there: Slurm's commands are needed for --on slurm" %
                         words[0]) from None
    return run


def largest_array():
    for line in call("scontrol", "show", "config").stdout.splitlines():
        name, _, value = line.partition("=")
        if name.strip() == "MaxArraySize" and value.strip().isdigit():
            return int(value)
    return USUAL_ARRAY


class Slurm:
    def __init__(self, program, store, options):
        self.program, self.store, self.options = program, store, options
        self.folder = store.folder / "slurm"
        self.mark = self.folder / "jobs.json"

    def run(self, numbers, progress):
        """Runs the cases. Those lost in every round are reported at the end."""
        self.folder.mkdir(exist_ok=True)
        total = len(numbers)
        for round_number in range(MOST_ROUNDS):
            jobs = self.jobs_underway() if round_number == 0 else []
            if not jobs:
                jobs = self.submit(numbers)
            self.follow(jobs, numbers, total, progress)
            self.mark.unlink()
            lost = sorted(set(numbers) - self.store.done())
            if not lost:
                return
            progress.tell("sweep: %d cases were lost (%s): they are submitted again" %
                          (len(lost), self.states(jobs)))
            numbers = lost
        progress.tell("sweep: %d cases were lost %d times; see %s" % (len(numbers), MOST_ROUNDS, self.folder))

    def submit(self, numbers):
        """Job arrays of tasks, each of some cases."""
        largest = largest_array()
        each = self.options.cases_per_task
        tasks = [numbers[i:i + each] for i in range(0, len(numbers), each)]
        jobs = []
        for first in range(0, len(tasks), largest - 1):
            part = tasks[first:first + largest - 1]
            name = "tasks_%d_%d" % (time.time_ns(), first)
            path = self.folder / (name + ".json")
            write_whole(path, json.dumps(part))
            task = shlex.join([*self.program, "--task-file", str(path)])
            words = ["sbatch", "--parsable", "--array=0-%d" % (len(part) - 1), "--job-name=sweep",
                     "--ntasks=1", "--cpus-per-task=1", "--output=%s/%s_%%a.log" % (self.folder, name)]
            for option in ("partition", "account", "time", "mem"):
                value = getattr(self.options, option)
                if value:
                    words.append("--%s=%s" % (option, value))
            run = call(*words, "--wrap=exec " + task)
            if run.returncode != 0:
                raise SystemExit("sweep: sbatch: " + run.stderr.strip())
            jobs.append(run.stdout.strip().split(";")[0])
            write_whole(self.mark, json.dumps(jobs))
        return jobs

    def jobs_underway(self):
        """Jobs still running from an earlier run of this program, which was interrupted."""
        if not self.mark.exists():
            return []
        jobs = json.loads(self.mark.read_text())
        return jobs if self.count(jobs) else []

    def count(self, jobs):
        """Number of tasks that wait or run; None if Slurm does not answer."""
        run = call("squeue", "--noheader", "--array", "--format=%T", "--jobs=" + ",".join(jobs))
        if run.returncode != 0:
            # Jobs that ended a while ago are no longer known.
            return 0 if "Invalid job id" in run.stderr else None
        return len(run.stdout.split())

    def follow(self, jobs, numbers, total, progress):
        asked = set(numbers)
        failures = 0
        told = set()
        while True:
            left = self.count(jobs)
            done = self.store.done() & asked
            for number in sorted(done - told):
                result = self.store.result(number)
                told.add(number)
                if result["status"] != "done":
                    progress.failed += 1
                    progress.tell("sweep: case %d %s: %s" % (number, result["status"], result["message"]))
            progress.set(total - len(asked) + len(done))
            if left == 0:
                return
            failures = failures + 1 if left is None else 0
            if failures > PATIENCE:
                raise SystemExit("sweep: squeue does not answer; run the same again to follow jobs " +
                                 ", ".join(jobs))
            time.sleep(self.options.poll)

    def states(self, jobs):
        """Final states of the tasks, if Slurm has accounting."""
        run = call("sacct", "--noheader", "--parsable2", "--allocations", "--format=State",
                   "--jobs=" + ",".join(jobs))
        names = sorted({line.split()[0] for line in run.stdout.splitlines() if line.strip()})
        return ", ".join(names) or "no account of why"


def task_cases(path, index):
    """The cases of one task of an array."""
    tasks = json.loads(open(path).read())
    if index is None or not 0 <= int(index) < len(tasks):
        print("sweep: --task-file: SLURM_ARRAY_TASK_ID is %s, expected 0 to %d" % (index, len(tasks) - 1),
              file=sys.stderr)
        raise SystemExit(1)
    return tasks[int(index)]
