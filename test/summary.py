#!/usr/bin/python3
"""Sums up a ctest run of catkin tests: summary.py TESTS_JSON CTEST_XML PASSED FAILED.

TESTS_JSON is ctest's list of tests, CTEST_XML its report. Prints the failures and, last,
'N passed, N failed' over all test cases, PASSED and FAILED included; exits 1 when any failed.
A test program that left no result, or that failed though its cases passed, is one failure.
"""

import json
import re
import sys
from xml.etree import ElementTree


def read_cases(path):
    """The test cases of a JUnit file and the files of rostest's nodes that it names."""
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError):
        return [], []
    nodes = re.findall(r"results are in \[([^]]+)\]", root.findtext("system-out") or "")
    return list(root.iter("testcase")), nodes


def problems_of(case):
    return case.findall("failure") + case.findall("error")


def cases_of(test):
    """The test cases behind one ctest test, from the file that catkin's run_tests.py expects."""
    command = test["command"]
    runner = next(i for i, word in enumerate(command) if word.endswith("/run_tests.py"))
    cases, nodes = read_cases(command[runner + 1])
    if nodes:  # a rostest's own case says only that its node reported
        cases = [case for case in cases if problems_of(case)]
    return cases + [case for node in nodes for case in read_cases(node)[0]]


def main(tests_json, ctest_xml, passed, failed):
    with open(tests_json) as file:
        tests = json.load(file)["tests"]
    succeeded = {
        case.get("name")
        for case in ElementTree.parse(ctest_xml).iter("testcase")
        if case.get("status") == "run"
    }
    if not tests:
        failed += 1
        print("FAILED: there is no such test")
    for test in tests:
        cases = cases_of(test)
        bad = [case for case in cases if problems_of(case)]
        skipped = [case for case in cases if case.find("skipped") is not None]
        passed += len(cases) - len(bad) - len(skipped)
        failed += len(bad)
        for case in bad:
            print(f"FAILED {case.get('classname')}.{case.get('name')}")
            for problem in problems_of(case):
                text = problem.text or problem.get("message") or ""
                print("  " + text.strip().replace("\n", "\n  "))
        if not cases or (not bad and test["name"] not in succeeded):
            failed += 1
            print(f"FAILED {test['name']}: crashed, timed out or exited with an error")
    print(f"{passed} passed, {failed} failed")
    return failed > 0


sys.exit(main(*sys.argv[1:3], *map(int, sys.argv[3:5])))
