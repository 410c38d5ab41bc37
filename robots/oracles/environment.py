"""What every oracle needs: an environment with its packages in target/oracles, and our examples, built.

Needs nothing but Python's standard library.
"""

import pathlib
import subprocess
import sys
import venv

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "target" / "oracles"


def skipped(reason):
    print(f"SKIPPED: {reason}")
    sys.exit(0)


def installed(packages):
    """The Python of an environment that has the packages; ends the program where there can be none."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    python = FOLDER / "venv" / "bin" / "python"
    if not python.exists():
        try:
            venv.create(FOLDER / "venv", with_pip=True)
        except (OSError, subprocess.CalledProcessError) as error:
            skipped(f"no virtual environment: {error}")
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *packages]
    done = subprocess.run(pip, capture_output=True, text=True)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or ["pip says nothing"]
        skipped(f"cannot install {', '.join(packages)}: {lines[-1]}")
    return python


def example(package, name):
    """The path of an example of ours, built."""
    build = ["cargo", "build", "--release", "--quiet", "-p", package, "--example", name]
    subprocess.run(build, cwd=ROOT, check=True)
    return ROOT / "target" / "release" / "examples" / name
