#!/usr/bin/python3
"""The commands of the documents exist: programs, their options, launch files, their arguments, scripts,
files. Commands of `simulate` are run, for a moment. The first hour has a test of its own, which runs all
of it. Argument: the folder of the programs (build/devel/lib/clothsim)."""

import functools
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
PROGRAMS = pathlib.Path(*sys.argv[1:2] or [PACKAGE / "build/devel/lib/clothsim"]).resolve()


def commands(text):
    """Commands in the blocks of a document, as lists of words."""
    for kind, block in re.findall(r"^ *```(\w*)\n(.*?)^ *```", text, re.DOTALL | re.MULTILINE):
        if kind not in ("", "sh", "bash"):
            continue
        for line in block.replace("\\\n", " ").splitlines():
            if re.match(r"(rosrun|roslaunch) clothsim |scripts/", line):
                yield shlex.split(line, comments=True)


@functools.lru_cache(None)
def help_of(program):
    return subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout


def arguments_of(launch_file):
    texts = [path.read_text() for path in (launch_file, PACKAGE / "launch/scene.launch")]
    return set(re.findall(r'<arg name="(\w+)"', "".join(texts)))


def run_for_a_moment(words):
    """The error message of `simulate`, empty if it succeeds."""
    at = words.index("--seconds") + 1 if "--seconds" in words else len(words)
    words = words[:at] + ["0.05"] + words[at + 1:]
    with tempfile.TemporaryDirectory() as folder:
        for of_clone in ("config", "docs"):
            (pathlib.Path(folder) / of_clone).symlink_to(PACKAGE / of_clone)
        for scene in (PACKAGE / "config/scenes").glob("*.yaml"):
            (pathlib.Path(folder) / scene.name).symlink_to(scene)
        done = subprocess.run([PROGRAMS / "simulate", *words], cwd=folder, capture_output=True,
                              text=True, check=False)
    return done.stderr if done.returncode else ""


def mistakes_of(words):
    if words[0].startswith("scripts/"):
        if not (PACKAGE / words[0]).is_file():
            yield f"there is no {words[0]}"
        return
    name, arguments = words[2], words[3:]
    if words[0] == "roslaunch":
        if not (PACKAGE / "launch" / name).is_file():
            yield f"there is no launch/{name}"
            return
        known = arguments_of(PACKAGE / "launch" / name)
        for argument in arguments:
            if ":=" in argument and argument.partition(":=")[0] not in known:
                yield f"{name} has no argument {argument}"
        return
    if not (PROGRAMS / name).is_file():
        yield f"there is no program {name}"
        return
    for argument in arguments:
        if argument.startswith("--") and argument.partition("=")[0] not in help_of(PROGRAMS / name):
            yield f"{name} has no option {argument}"
        if argument.startswith("config/") and not (PACKAGE / argument).exists():
            yield f"there is no {argument}"
    if name == "simulate":
        failure = run_for_a_moment(arguments)
        if failure:
            yield failure


def main():
    count, wrong = 0, 0
    for path in (PACKAGE / "README.md", *sorted((PACKAGE / "docs").glob("*.md"))):
        for words in commands(path.read_text()):
            count += 1
            for mistake in mistakes_of(words):
                wrong += 1
                print(f"{path.relative_to(PACKAGE)}: {' '.join(words)}: {mistake}")
    print(f"{count} commands")
    return int(wrong > 0 or count == 0)


if __name__ == "__main__":
    sys.exit(main())
