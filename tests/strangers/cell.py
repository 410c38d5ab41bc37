"""The programs under test, as processes of their own, and a wait that ends.

MRROC_BIN names the folder of the programs; `cargo xtask strangers` sets it.
"""

import contextlib
import functools
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

import can

BIN = pathlib.Path(os.environ.get("MRROC_BIN", "target/debug"))
ROOT = pathlib.Path(__file__).resolve().parents[2]

# What a candump log calls the second bus of a run whose name is longer than that of a Linux interface, 15 letters:
# irp6-postument.0 is.
LOG_CHANNEL = "bus1"

# Drive units of the IRp-6: 1000 per increment of 4000 a turn.
UNITS_PER_TURN = 4_000_000


def tool(*arguments):
    """What a program prints; an error if it fails."""
    command = [str(BIN / arguments[0]), *arguments[1:]]
    return subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout


def start(*arguments):
    """A program that prints JSON lines."""
    command = [str(BIN / arguments[0]), *arguments[1:]]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT
    )


def end(process):
    """Ends a program as Ctrl-C does, and reads its last words."""
    process.send_signal(signal.SIGINT)
    try:
        rest, _ = process.communicate(timeout=20)
    except subprocess.TimeoutExpired:
        process.kill()
        rest, _ = process.communicate()
    return rest


@contextlib.contextmanager
def simulator(*robots, bus="hub:0"):
    """Simulated robots behind a hub; gives its port."""
    process = start("mrroc-hil-sim", *robots, "--bus", bus, "--json")
    try:
        for line in process.stdout:
            event = json.loads(line)
            if event["event"] == "ready":
                break
        else:
            raise RuntimeError("the simulator ended before it was ready")
        yield event["port"]
    finally:
        end(process)


def until(condition, what, seconds=20.0, pause=0.01):
    """Waits until `condition` is true; the time only ends what hangs."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(pause)


def in_real_time(case):
    """Class decorator: each test of a case has up to three attempts, each from `setUp` on.

    A tool that the machine does not let run for 200 ms misses a SYNC that the simulator waited for, and a drive
    then stops as it should. That says nothing about either side. What is wrong is wrong three times.
    """

    def patient(test):
        @functools.wraps(test)
        def attempt(self):
            for left in (2, 1, 0):
                try:
                    return test(self)
                except unittest.SkipTest:
                    raise
                except Exception as error:
                    if left == 0:
                        raise
                    print(f"once more: {test.__name__}: {error!r}", file=sys.stderr)
                self.doCleanups()
                self.setUp()

        return attempt

    for name, test in list(vars(case).items()):
        if name.startswith("test"):
            setattr(case, name, patient(test))
    return case


def joined(join):
    """What `join` gives: python-can sometimes reads the first frames with the answer it waits for."""
    for _ in range(5):
        try:
            return join()
        except can.CanError:
            time.sleep(0.2)
    return join()
