#!/usr/bin/python3
"""rosrun clothsim sweep as a user runs it: the table of cases, runs here and on a cluster of Slurm."""

import csv
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import h5py
import numpy as np
import PIL.Image
import rosunit
import yaml

HERE = pathlib.Path(__file__).resolve().parent
SCRIPTS = HERE.parent.parent / "scripts"
sys.path[:0] = [str(SCRIPTS), str(HERE.parent)]
from sweeping.plan import BadSweep, Plan  # noqa: E402
from cluster import Cluster, read_environment  # noqa: E402
from says import says  # noqa: E402

SIMULATE = HERE.parent.parent / "build" / "devel" / "lib" / "clothsim" / "simulate"
SCENE = "cloth: {columns: 6, rows: 6, pinned: [[0, 0], [5, 0]]}\n"
PATIENCE = 300  # [s] for machines that are busy with something else


class Sweeps(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="sweep"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "scene.yaml").write_text(SCENE)
        self.out = self.folder / "out"

    def write(self, sweep):
        path = self.folder / "sweep.yaml"
        path.write_text(yaml.safe_dump({"scene": "scene.yaml", "seconds": 0.05, **sweep}, sort_keys=False))
        return path

    def cases(self, sweep):
        return Plan(self.write(sweep)).cases

    def run_sweep(self, *options, code=0, output=None, environment=None):
        run = subprocess.run(
            [str(SCRIPTS / "sweep"), str(self.folder / "sweep.yaml"), "--output", str(output or self.out),
             *options], capture_output=True, text=True, timeout=PATIENCE, check=False, env=environment)
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run

    def rows(self, output=None):
        with open((output or self.out) / "results.csv") as file:
            return list(csv.DictReader(file))

    def final(self, number, output=None):
        return ((output or self.out) / "cases" / ("%06d" % number) / "final.csv").read_bytes()


class Table(Sweeps):
    """Tables of cases, from the axes."""

    def test_lists_and_ranges_make_a_grid(self):
        cases = self.cases({"axes": {"a": [1, "x", [0, 0, 1]], "b": {"range": [0, 1], "count": 3},
                                     "c": {"log_range": [10, 1000], "count": 3}}})
        self.assertEqual(len(cases), 27)
        self.assertEqual(cases[0], {"a": 1, "b": 0, "c": 10})
        self.assertEqual(cases[-1], {"a": [0, 0, 1], "b": 1, "c": 1000})
        self.assertEqual(sorted({case["b"] for case in cases}), [0, 0.5, 1])
        self.assertAlmostEqual(cases[1]["c"], 100, delta=1e-12)

    def test_random_axes_are_those_of_the_seed(self):
        sweep = {"axes": {"a": {"random": [2, 3]}, "b": {"log_random": [1e-3, 1e3]}, "c": [1, 2]},
                 "samples": 400, "seed": 7}
        cases = self.cases(sweep)
        self.assertEqual(len(cases), 800)
        self.assertEqual(cases, self.cases(sweep))
        self.assertNotEqual(cases, self.cases({**sweep, "seed": 8}))
        # Means of 400 uniform numbers are within five standard deviations, 1 / sqrt(12 * 400) each.
        tolerance = 5 / math.sqrt(12 * 400)
        self.assertAlmostEqual(sum(case["a"] for case in cases) / 800, 2.5, delta=tolerance)
        self.assertAlmostEqual(sum(math.log10(case["b"]) for case in cases) / 800, 0, delta=6 * tolerance)
        self.assertTrue(all(2 <= case["a"] <= 3 for case in cases))

    def test_latin_hypercube_has_one_sample_in_each_row_and_column(self):
        cases = self.cases({"axes": {"a": {"latin": [0, 50]}, "b": {"log_latin": [1, 2**50]}}, "samples": 50})
        for of_axis in (lambda case: case["a"], lambda case: math.log2(case["b"])):
            self.assertEqual(sorted(int(of_axis(case)) for case in cases), list(range(50)))

    def test_axes_set_several_keys(self):
        plan = Plan(self.write({"set": {"cloth.ks": 1, "cloth.rows": 7}, "axes": {
            "slow": {"list": [1, 2], "keys": {"motions.0.time": 0.5, "motions.1.time": 1}},
            "fabric": {"choices": {"silk": {"cloth.ks": 50}, "felt": {"cloth.ks": 5000, "cloth.density": 300}}}}}))
        self.assertEqual(plan.settings(3), {"cloth.ks": 5000, "cloth.rows": 7, "cloth.density": 300,
                                            "motions.0.time": 1.0, "motions.1.time": 2})
        self.assertEqual(plan.cases[2], {"slow": 2, "fabric": "silk"})

    def test_mistakes(self):
        axes = {"axes": {"cloth.ks": [1]}}
        for sweep, message in (
                ({}, "axes: got null ... map"),
                ({"axes": {}}, "axes: got {}"),
                ({**axes, "scene": "moon.yaml"}, 'scene: got "moon.yaml" ... file'),
                ({**axes, "scenes": 1}, "sweep.yaml.scenes: got ... unknown ... scene,"),
                ({**axes, "seconds": "long"}, 'seconds: got "long" ... finite number'),
                ({**axes, "samples": 3}, "samples: got 3 ... none"),
                ({**axes, "measure": "m.py"}, 'measure: got "m.py" ... file'),
                ({**axes, "set": [1]}, "set: got [1] ... map"),
                ({**axes, "view": "v.yaml"}, 'view: got "v.yaml" ... file'),
                ({**axes, "video": "out.mp4"}, 'video: got "out.mp4" ... true or false'),
                ({"axes": {"a": []}}, "axes.a.list: got [] ... list of values"),
                ({"axes": {"a": 5}}, "axes.a: got 5 ... map"),
                ({"axes": {"a": {}}}, "axes.a: got none ... list, range"),
                ({"axes": {"a": {"range": [1, 2], "random": [1, 2]}}}, "axes.a: got range, random"),
                ({"axes": {"a": {"range": [1, 2]}}}, "axes.a.count: got null ... whole number"),
                ({"axes": {"a": {"range": [1, 2], "count": 1}}}, "axes.a.count: got 1"),
                ({"axes": {"a": {"range": [1, "b"], "count": 2}}}, 'axes.a.range: got "b"'),
                ({"axes": {"a": {"range": [1, float("nan")], "count": 2}}}, "axes.a.range: got NaN"),
                ({"axes": {"a": {"log_range": [0, 2], "count": 2}}}, "axes.a.log_range: got [0, 2]"),
                ({"axes": {"a": {"random": [0, 2]}}}, "samples: got null"),
                ({"axes": {"a": {"random": [0, 2], "count": 3}}, "samples": 2}, "axes.a.count: got 3"),
                ({"axes": {"a": {"choices": {"b": 1}}}}, "axes.a.choices: got"),
                ({"axes": {"a": {"list": [1], "keys": []}}}, "axes.a.keys: got []"),
                ({"axes": {"a": {"range": [0, 1], "count": 2000}, "b": {"range": [0, 1], "count": 2000}}},
                 "axes: got 4000000 cases ... most 1000000")):
            with self.assertRaises(BadSweep) as caught:
                Plan(self.write(sweep))
            self.assertRegex(str(caught.exception), says(message))
        self.assertIn("sweep: axes: got {}", self.run_sweep(code=1).stderr if self.write({"axes": {}}) else "")
        (self.folder / "sweep.yaml").write_text("a: [")
        self.assertIn("YAML", self.run_sweep(code=1).stderr)


class Here(Sweeps):
    """Runs on this machine."""

    def test_results_are_those_of_simulate(self):
        self.write({"axes": {"cloth.ks": [500, 5000], "cloth.damping": {"range": [0, 5], "count": 2}},
                    "every": 0.05})
        run = self.run_sweep("--plot", "cloth.ks", "cloth.damping", "mean_stretch")
        self.assertIn("4 cases: 4 done, 0 failed, 0 missing; 4 now", run.stdout)
        rows = self.rows()
        self.assertEqual([(row["case"], row["cloth.ks"], row["cloth.damping"]) for row in rows],
                         [("0", "500", "0.0"), ("1", "500", "5.0"), ("2", "5000", "0.0"), ("3", "5000", "5.0")])
        direct = self.folder / "direct"
        subprocess.run([SIMULATE, self.folder / "scene.yaml", "--seconds", "0.05", "--set", "cloth.ks=500",
                        "--set", "cloth.damping=5", "--output", direct], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(self.final(1), (direct / "final.csv").read_bytes())
        report = yaml.safe_load((direct / "report.yaml").read_text())
        self.assertEqual(float(rows[1]["energy.kinetic"]), report["energy"]["kinetic"])
        self.assertTrue((self.out / "cases" / "000001" / "frames.npz").exists())
        self.assertTrue((self.out / "plot_cloth.ks_cloth.damping_mean_stretch.png").exists())
        with h5py.File(self.out / "results.h5") as file:
            self.assertEqual(list(file["energy.kinetic"]), [float(row["energy.kinetic"]) for row in rows])
            self.assertEqual(file["status"].asstr()[2], "done")
        self.assertEqual((self.out / "cases.csv").read_text().splitlines()[:2],
                         ["case,cloth.ks,cloth.damping", "0,500,0.0"])
        self.assertRegex(self.run_sweep("--plot", "moon", "cloth.ks", code=1).stderr,
                         says("--plot: got moon ... case,"))

    def test_done_cases_are_skipped(self):
        self.write({"axes": {"cloth.ks": [500, 1000, 2000]}})
        self.run_sweep()
        before = self.final(1)
        shutil.rmtree(self.out / "cases" / "000001")
        mark = self.out / "cases" / "000002" / "kept"
        mark.touch()
        self.assertIn("3 done, 0 failed, 0 missing; 1 now", self.run_sweep().stdout)
        self.assertEqual(self.final(1), before)
        self.assertTrue(mark.exists())

    def test_failures_are_told_and_kept(self):
        self.write({"axes": {"cloth.ks": [500, -1, 5000]}})
        run = self.run_sweep(code=2)
        self.assertIn("case 1 failed: simulate: cloth.ks: got -1", run.stderr)
        self.assertIn("3 cases: 2 done, 1 failed, 0 missing", run.stdout)
        self.assertEqual([row["status"] for row in self.rows()], ["done", "failed", "done"])
        self.assertIn("0 now", self.run_sweep(code=2).stdout)
        self.assertIn("1 now", self.run_sweep("--retry-failed", code=2).stdout)

    def test_measure(self):
        shutil.copy(HERE / "measure.py", self.folder)
        self.write({"axes": {"simulation.gravity": [[0, 0, -1], [0, 0, -1e3]]}, "measure": "measure.py"})
        run = self.run_sweep(code=2)
        self.assertIn("case 1 failed: ValueError: it fell to", run.stderr)
        rows = self.rows()
        self.assertTrue(0.99 < float(rows[0]["lowest"]) < 1)
        self.assertAlmostEqual(float(rows[0]["span.z"]), 1 - float(rows[0]["lowest"]), delta=1e-3)
        self.assertEqual((rows[1]["status"], rows[1]["lowest"]), ("failed", ""))

    def test_a_measure_may_fail_in_any_way(self):
        (self.folder / "measure.py").write_text(
            "import os, numpy as np\n"
            "def measure(folder):\n"
            "    case = int(folder.name.split('.')[1])\n"
            "    if case == 1: os._exit(3)\n"
            "    if case == 2: raise SystemExit('no more')\n"
            "    if case == 3: return 3\n"
            "    if case == 4: return {'a': object()}\n"
            "    return {'ok': np.bool_(case == 0), 'n': np.int64(7), 'f': np.float32(0.5)}\n")
        self.write({"axes": {"cloth.ks": {"range": [500, 900], "count": 7}}, "measure": "measure.py"})
        run = self.run_sweep("--plot", "n", "f", "status", code=2)
        rows = self.rows()
        self.assertEqual([row["status"] for row in rows], ["done"] + 4 * ["failed"] + 2 * ["done"])
        self.assertEqual([row["ok"] for row in rows if row["ok"]], ["True", "False", "False"])
        self.assertEqual((rows[0]["n"], rows[0]["f"]), ("7", "0.5"))
        for case, message in enumerate(["its worker was killed 3 times", "SystemExit: no more",
                                        "expected a dict", "expected numbers and texts"], 1):
            self.assertIn("case %d failed: " % case, run.stderr)
            self.assertIn(message, rows[case]["message"])
        self.assertTrue((self.out / "plot_n_f_status.png").exists())

    def test_views(self):
        (self.folder / "view.yaml").write_text("width: 24\nheight: 16\n")
        self.write({"axes": {"cloth.ks": [500, 5000], "view.cloth.color": [[1, 0, 0], [0, 1, 0]]},
                    "view": "view.yaml", "set": {"view.height": 18}, "video": True, "every": 0.05})
        self.run_sweep()
        pictures = [np.asarray(PIL.Image.open(self.out / "cases" / ("%06d" % i) / "final_color.png"))
                    for i in range(4)]
        self.assertEqual(pictures[0].shape, (18, 24, 3))
        for red, green in ((pictures[0], pictures[1]), (pictures[2], pictures[3])):
            self.assertTrue((red[..., 0] > green[..., 0]).any() and (green[..., 1] > red[..., 1]).any())
        self.assertEqual([self.final(0), self.final(2)], [self.final(1), self.final(3)])
        case = self.out / "cases" / "000003"
        self.assertTrue((case / "frames" / "000000_depth.png").exists())
        self.assertGreater((case / "video.mp4").stat().st_size, 0)
        plain = self.folder / "plain"
        self.write({"axes": {"cloth.ks": [500, 5000]}})
        self.run_sweep(output=plain)
        self.assertEqual(self.final(1, plain), self.final(2), "pictures change no bit of the cloth")
        self.assertFalse((plain / "cases" / "000001" / "final_color.png").exists())

    def test_mistakes_in_views(self):
        self.write({"axes": {"view.cloth.shader": ["wireframe", "moon"]}, "set": {"view.width": 20}})
        self.assertIn("case 1 failed: film: cloth.shader: got \"moon\"", self.run_sweep(code=2).stderr)

    def test_from_a_state(self):
        subprocess.run([SIMULATE, self.folder / "scene.yaml", "--seconds", "0.05", "--output", self.folder],
                       check=True, stdout=subprocess.DEVNULL)
        self.write({"axes": {"cloth.damping": [5.4, 20]}, "from": "final.npz"})
        self.run_sweep()
        twice = self.folder / "twice"
        subprocess.run([SIMULATE, self.folder / "scene.yaml", "--seconds", "0.05", "--from",
                        self.folder / "final.npz", "--output", twice], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(self.final(0), (twice / "final.csv").read_bytes())
        self.assertNotEqual(self.final(0), self.final(1))

    def test_shards_and_gnu_parallel(self):
        self.write({"axes": {"cloth.ks": {"range": [500, 900], "count": 5}}})
        self.assertIn("3 done, 0 failed, 2 missing; 3 now", self.run_sweep("--shard", "1/2").stdout)
        self.assertIn("5 done, 0 failed, 0 missing; 2 now", self.run_sweep("--shard", "2/2").stdout)
        whole = self.out
        for bad in ("0/2", "3/2", "1", "a/b"):
            self.assertIn("expected i/n", self.run_sweep("--shard", bad, code=2).stderr)
        self.out = self.folder / "by_parallel"
        line = self.run_sweep("--parallel", "3").stdout
        self.assertTrue(line.startswith("parallel "), line)
        subprocess.run(line, shell=True, check=True, timeout=PATIENCE, stdout=subprocess.DEVNULL,
                       env={**os.environ, "PARALLEL_HOME": str(self.folder)})
        self.assertEqual([self.final(i) for i in range(5)], [self.final(i, whole) for i in range(5)])

    def test_another_sweep_is_not_mixed_in(self):
        self.write({"axes": {"cloth.ks": [500]}})
        self.run_sweep()
        self.write({"axes": {"cloth.ks": [600]}})
        self.assertIn("holds another sweep", self.run_sweep(code=1).stderr)
        self.write({"axes": {"cloth.ks": [500]}})
        (self.folder / "scene.yaml").write_text(SCENE + "simulation: {seed: 2}\n")
        self.assertIn("files of this one have changed", self.run_sweep(code=1).stderr)

    def start(self):
        return subprocess.Popen([str(SCRIPTS / "sweep"), str(self.folder / "sweep.yaml"), "--output",
                                 str(self.out)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                start_new_session=True)

    def wait_for_cases(self, count):
        end = time.monotonic() + PATIENCE
        while len(list((self.out / "cases").glob("[0-9]*"))) < count:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def test_interrupted_and_gone_on(self):
        self.write({"axes": {"cloth.ks": {"range": [500, 900], "count": 40}}, "seconds": 2})
        run = self.start()
        self.wait_for_cases(3)
        os.killpg(run.pid, signal.SIGINT)  # as a terminal does
        self.assertIn("interrupted", run.communicate(timeout=PATIENCE)[1])
        self.assertEqual(run.returncode, 130)
        done = len(list((self.out / "cases").glob("[0-9]*")))
        self.assertLess(done, 40)
        self.assertIn("40 done, 0 failed, 0 missing; %d now" % (40 - done), self.run_sweep().stdout)

    def test_a_killed_worker_loses_nothing(self):
        self.write({"axes": {"cloth.ks": {"range": [500, 900], "count": 30}}, "seconds": 2})
        run = self.start()
        self.wait_for_cases(3)
        while not (parts := list((self.out / "cases").glob(".*.part"))):  # between two cases
            self.assertIsNone(run.poll())
        os.kill(int(parts[0].name.split(".")[-2]), signal.SIGKILL)  # a worker, by the name of its folder
        self.assertIn("", run.communicate(timeout=PATIENCE)[1])
        self.assertEqual(run.returncode, 0)
        self.assertEqual(len(self.rows()), 30)


class OnSlurm(Sweeps):
    CASES = 200

    def test_node_fails_midway(self):
        """Slurm itself must not run tasks of a lost node again: the sweep has to."""
        self.write({"axes": {"cloth.ks": {"log_range": [100, 10000], "count": self.CASES // 2},
                             "cloth.damping": [1, 5]}, "seconds": 0.3})
        here = self.folder / "here"
        self.run_sweep(output=here)
        cluster = Cluster(self.folder / "cluster")
        self.addCleanup(cluster.stop)
        cluster.start()
        run = subprocess.Popen(
            [str(SCRIPTS / "sweep"), str(self.folder / "sweep.yaml"), "--output", str(self.out), "--on",
             "slurm", "--cases-per-task", "10", "--partition", "test", "--poll", "0.5"],
            env=cluster.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        cluster.wait(lambda: len(list((self.out / "cases").glob("[0-9]*"))) >= 10, "some cases")
        cluster.wait(lambda: self.stops_in_a_case(b"SLURMD_NODENAME=node1"), "a case on node1")
        cluster.kill_node("node1")
        out, err = run.communicate(timeout=PATIENCE)
        self.assertEqual(run.returncode, 0, out + err + cluster.logs())
        self.assertIn("cases were lost", err)
        self.assertIn("%d done, 0 failed, 0 missing" % self.CASES, out)
        self.assertEqual([row["case"] for row in self.rows()], [str(i) for i in range(self.CASES)])
        for number in range(self.CASES):
            self.assertEqual(self.final(number), self.final(number, here), number)
        self.assertEqual(len(list((self.out / "cases").iterdir())), self.CASES)

    def stops_in_a_case(self, of_node):
        """Stops a worker within a case, by the name of its folder. A worker that is then killed loses the case."""
        for part in (self.out / "cases").glob(".[0-9]*.part"):
            pid = int(part.name.split(".")[-2])
            if of_node in read_environment(pid):
                os.kill(pid, signal.SIGSTOP)
                if part.exists():
                    return True
                os.kill(pid, signal.SIGCONT)
        return False

    def test_mistakes(self):
        self.write({"axes": {"cloth.ks": [500]}})
        # A cluster that nobody has started. Without its configuration file Slurm's commands try for a minute each.
        alone = {**Cluster(self.folder / "cluster").environment, "PATH": "/nowhere:/usr/bin/../bin"}
        self.assertIn("sweep: sbatch: ", self.run_sweep("--on", "slurm", code=1, environment=alone).stderr)


if __name__ == "__main__":
    rosunit.unitrun("clothsim", "sweep_" + sys.argv[1], "__main__." + sys.argv[1])
