#!/usr/bin/env python3
"""Tells how a run of `meson test` went:
    test_summary.py BUILD_DIR COUNTS_FILE [--no-suite SUITE]... [TEST]...

Prints a line a test (and the end of the output of those that failed) and writes
"passed failed skipped" to COUNTS_FILE. A test that was due and left no result has failed.
"""
import json
import os
import subprocess
import sys

TAIL_LINES = 40
PASSED = {"OK", "EXPECTEDFAIL"}
SKIPPED = {"SKIP", "IGNORED"}


def tail(text):
    lines = (text or "").rstrip().splitlines()
    if len(lines) > TAIL_LINES:
        lines = [f"... {len(lines) - TAIL_LINES} lines before"] + lines[-TAIL_LINES:]
    return ["    | " + line for line in lines]


def last_line(text):
    lines = (text or "").strip().splitlines()
    return lines[-1].strip() if lines else ""


def due_tests(build, without):
    """Names as they were defined, but for those of suites that are left out."""
    out = subprocess.run(["meson", "introspect", "--tests", build], check=True,
                         capture_output=True, text=True).stdout
    left_out = {"bitangent:" + suite for suite in without}
    return [test["name"] for test in json.loads(out) if not left_out & set(test["suite"])]


def results_of(build):
    path = os.path.join(build, "meson-logs", "testlog.json")
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8", errors="replace") as log:
        return [json.loads(line) for line in log if line.strip()]


def main():
    build, counts_file, only = sys.argv[1], sys.argv[2], sys.argv[3:]
    without = []
    while only and only[0] == "--no-suite":
        without.append(only[1])
        only = only[2:]
    passed = failed = skipped = 0
    seen = set()
    for result in results_of(build):
        # "bitangent:suite / name" in the log, "name" where it was defined
        name = result["name"].split(" / ")[-1]
        seen.add(name)
        output = result.get("stdout", "")
        if result["result"] in PASSED:
            passed += 1
            print(f"  passed   {name}  ({result['duration']:.1f} s)")
        elif result["result"] in SKIPPED:
            skipped += 1
            print(f"  skipped  {name}: {last_line(output) or 'no reason given'}")
        else:
            failed += 1
            print(f"  FAILED   {name}  ({result['result']}, {result['duration']:.1f} s)")
            print("\n".join(tail(output) + tail(result.get("stderr"))))
    for name in only or due_tests(build, without):
        if name not in seen:
            failed += 1
            print(f"  FAILED   {name}: no result, see {build}/test-output.txt")
    if passed + failed + skipped == 0:
        print(f"  no test ran, see {build}/test-output.txt")
    with open(counts_file, "w", encoding="ascii") as out:
        print(passed, failed, skipped, file=out)


main()
