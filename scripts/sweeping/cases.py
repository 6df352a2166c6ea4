"""Runs cases, each in a folder that gets its name when the case is done."""

import collections.abc
import importlib.util
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import traceback

import numpy as np
import yaml

from sweeping.plan import VIEW

RESULT = "result.json"
INTERRUPTED = 130  # exit code of simulate and film

# Length of an error message in the table.
LONGEST_MESSAGE = 500

# Attempts at a simulation that is killed, and the pause before the next attempt [s].
MOST_ATTEMPTS = 3
PAUSE = 2.0


class Store:
    """The folder of a sweep. A case is done when its folder has its name; until then it is hidden."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder).resolve()
        self.cases = self.folder / "cases"

    def open(self, plan):
        """Claims the folder for a sweep; results of another sweep are not touched."""
        self.cases.mkdir(parents=True, exist_ok=True)
        mark = self.folder / "sweep.json"
        ours = {"fingerprint": plan.fingerprint(), "cases": len(plan.cases)}
        if not mark.exists():
            write_whole(mark, json.dumps(ours))
        if json.loads(mark.read_text()) != ours:
            raise SystemExit("sweep: %s: holds another sweep, or files of this one have changed since; "
                             "take another folder" % self.folder)

    def path(self, number):
        return self.cases / ("%06d" % number)

    def done(self):
        """Numbers of the cases that are done, including those that failed."""
        return {int(entry.name) for entry in os.scandir(self.cases) if entry.name.isdigit()}

    def result(self, number):
        return json.loads((self.path(number) / RESULT).read_text())

    def forget(self, number):
        shutil.rmtree(self.path(number))

    def forget_unfinished(self):
        """Removes the leftovers of killed runs, once all cases are done."""
        for entry in os.scandir(self.cases):
            if entry.name.startswith("."):
                shutil.rmtree(entry.path, ignore_errors=True)


def write_whole(path, text):
    part = path.with_name(".%s.%d.part" % (path.name, os.getpid()))
    part.write_text(text)
    part.rename(path)


class Case:
    """All that a process needs to run one case of a plan."""

    def __init__(self, program, plan, number):
        self.number, self.parameters, self.measure = number, plan.cases[number], plan.measure
        self.command, self.video = [str(program), str(plan.scene)], plan.video
        for key, value in plan.settings(number).items():
            option, key = ("--look", key[len(VIEW):]) if key.startswith(VIEW) else ("--set", key)
            self.command += [option, "%s=%s" % (key, json.dumps(value))]
        if plan.view:
            self.command += ["--view", str(plan.view)]
        for name, value in plan.times.items():
            self.command += ["--" + name, repr(value)]
        if plan.start:
            self.command += ["--from", str(plan.start)]


def flat(values, prefix=""):
    """Numbers and texts of nested maps, keys joined by dots."""
    for key, value in values.items():
        if isinstance(value, dict):
            yield from flat(value, prefix + key + ".")
        elif isinstance(value, (bool, int, float, str)):
            yield prefix + key, value


def load_measure(path):
    spec = importlib.util.spec_from_file_location("measure", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.measure


def as_plain(value):
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError("measure: got %r, expected numbers and texts" % (value,))


def measured(case, part):
    """The results of the user's measure() for a case. Raises its exceptions, or TypeError."""
    values = load_measure(case.measure)(part)
    if not isinstance(values, collections.abc.Mapping):
        raise TypeError("measure: got %r, expected a dict" % (values,))
    return flat(json.loads(json.dumps(dict(values), default=as_plain)))


def keep(case, store, part, result):
    """Moves the folder `part` of a finished case to its final place."""
    (part / RESULT).write_text(json.dumps(result))
    try:
        part.rename(store.path(case.number))
    except OSError:
        shutil.rmtree(part)  # another process was faster
        if not store.path(case.number).exists():
            raise
    return result


def part_of(case, store):
    """Folder of a case that this process works on."""
    return store.cases / (".%06d.%s.%d.part" % (case.number, os.uname().nodename, os.getpid()))


def fail(case, store, message):
    """Stores a case as failed with a message, and returns its result."""
    part = part_of(case, store)
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    return keep(case, store, part, {"case": case.number, "parameters": case.parameters, "results": {},
                                    "status": "failed", "message": message, "case_seconds": 0.0})


def run_program(case, part):
    """Runs a case in an empty folder. A run that is killed, for example for lack of memory, is tried again
    after a pause, as this process may be about to be killed as well."""
    for attempt in range(MOST_ATTEMPTS):
        time.sleep(attempt * PAUSE)
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir()
        video = ["--video", str(part / "video.mp4")] if case.video else []
        run = subprocess.run([*case.command, "--output", str(part), *video], stdin=subprocess.DEVNULL,
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False,
                             env={"LP_NUM_THREADS": "1", **os.environ})  # of Mesa's renderer
        if run.returncode != -signal.SIGKILL:
            break
    return run


def run_case(case, store):
    """Runs a case, unless another process is faster. Returns its result, or None after an interrupt."""
    begin = time.monotonic()
    part = part_of(case, store)
    run = run_program(case, part)
    if run.returncode == INTERRUPTED:
        shutil.rmtree(part)
        return None
    result = {"case": case.number, "parameters": case.parameters, "results": {}}
    result["status"] = {0: "done", 2: "diverged"}.get(run.returncode, "failed")
    result["message"] = run.stderr.strip()[-LONGEST_MESSAGE:] if run.returncode else ""
    if run.returncode < 0:
        result["message"] = "%s: killed by signal %d" % (
            pathlib.Path(case.command[0]).name, -run.returncode)
    report = part / "report.yaml"
    if report.exists():
        values = yaml.load(report.read_text(), Loader=LOADER)
        result["results"] = {key: value for key, value in flat(values) if key != "scene"}
    if case.measure and result["status"] == "done":
        try:
            result["results"].update(measured(case, part))
        except (Exception, SystemExit):  # the user's own code
            result["status"] = "failed"
            lines = traceback.format_exc().strip()[-LONGEST_MESSAGE:].split("\n")
            result["message"] = "\n".join(lines[1:])  # the first is "Traceback", or cut
    result["case_seconds"] = time.monotonic() - begin
    return keep(case, store, part, result)


LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
