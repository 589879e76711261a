"""count_tests.py CHECKOUT BUILD RESULTS OPTIONS: what scripts/test says at the end, and its exit code.

Single cases are counted where a program reported them as JUnit XML (gtest, rostest); a test that left no report, such as
one that crashed, counts as one, with what ctest says of it. Fails if a test file of the checkout did not run, or if there
were fewer cases than test/fewest_cases.txt says; with OPTIONS > 0 a selection was asked for, and neither is checked.
"""
import glob
import os
import re
import sys
import xml.etree.ElementTree as ElementTree


def cases_of(path):
    """Cases of a report: passed, names of the failed, (name, reason) of the skipped."""
    passed, failed, skipped = 0, [], []
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        name = "%s.%s" % (case.get("classname", "").replace("__main__.", ""), case.get("name", ""))
        reason = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None:
            failed.append(name)
        elif reason is not None or case.get("status") == "notrun" or case.get("result") in ("skipped", "suppressed"):
            text = (reason.get("message") or reason.text or "") if reason is not None else "disabled"
            # gtest puts file and line before the reason.
            lines = [line for line in text.strip().splitlines() if not re.match(r"^\S+\.(cpp|h):\d+$", line)]
            skipped.append((name, " ".join(lines) or "no reason given"))
        else:
            passed += 1
    return passed, failed, skipped


def skip_reason(results, name):
    """What a test that ctest knows only as skipped has left to say."""
    try:
        with open(os.path.join(results, name + ".skipped")) as file:
            return file.read().strip()
    except OSError:
        return "said so"


def expected_tests(checkout):
    """Names of the ctest tests that the files of the checkout make: see cmake/tests.cmake and cmake/ros_tests.cmake."""
    def stem(path):
        return os.path.basename(path).split(".")[0]
    names = {stem(path) for path in glob.glob(os.path.join(checkout, "test", "*", "*_test.cpp"))
             if os.path.basename(os.path.dirname(path)) not in ("consumer", "benchmark")}
    names |= {"ros_" + stem(path) for path in glob.glob(os.path.join(checkout, "test", "ros", "*.test"))}
    return names | {"consumer", "fuzz", "documented_commands", "installed_launch", "soak"}


def main():
    checkout, _, results, options = sys.argv[1:5]
    passed, failed, skipped, ran = 0, [], [], set()
    with open(os.path.join(results, "ctest.log"), errors="replace") as log:
        lines = re.findall(r"^ *\d+/\d+ Test +#\d+: (\S+) \.*[ *]*(Passed|Skipped|\S.*?) +[\d.]+ sec", log.read(), re.M)
    for name, verdict in lines:
        ran.add(name)
        reports = glob.glob(os.path.join(results, "gtest", name + ".xml")) + \
            glob.glob(os.path.join(results, "rostest", name, "**", "rosunit-*.xml"), recursive=True)
        before = len(failed)
        for report in reports:
            try:
                more_passed, more_failed, more_skipped = cases_of(report)
            except ElementTree.ParseError:
                continue
            passed += more_passed
            failed += more_failed
            skipped += more_skipped
        if verdict == "Skipped":
            skipped.append((name, skip_reason(results, name)))
        elif verdict != "Passed" and len(failed) == before:
            failed.append("%s (%s)" % (name, verdict.strip("*")))
        elif verdict == "Passed" and not reports:
            passed += 1

    print()
    for name, reason in skipped:
        print("skipped: %s: %s" % (name, reason))
    for name in failed:
        print("failed: " + name)
    complete = True
    if options == "0":
        for name in sorted(expected_tests(checkout) - ran):
            print("did not run: " + name)
            complete = False
        with open(os.path.join(checkout, "test", "fewest_cases.txt")) as file:
            fewest = int(file.read().split()[0])
        if passed + len(failed) + len(skipped) < fewest:
            print("only %d cases, expected at least %d (test/fewest_cases.txt)" %
                  (passed + len(failed) + len(skipped), fewest))
            complete = False
    elif not ran:
        print("the options select no test")
        complete = False
    print("%d passed, %d failed, %d skipped" % (passed, len(failed), len(skipped)), flush=True)
    return 0 if complete and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
