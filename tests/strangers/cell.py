"""The programs under test, as processes of their own, and a wait that ends.

MRROC_BIN names the folder of the programs; `cargo xtask strangers` sets it.
"""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import time

BIN = pathlib.Path(os.environ.get("MRROC_BIN", "target/debug"))
ROOT = pathlib.Path(__file__).resolve().parents[2]

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


def until(condition, what, seconds=20.0):
    """Waits until `condition` is true; the time only ends what hangs."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.01)
