"""The dynamics of the chains against Pinocchio and MuJoCo: installs them, builds, compares. See README.md.

Needs nothing but Python's standard library; what it fetches goes into target/oracles. Prints SKIPPED with the
reason, and exits with 0, where Pinocchio cannot be installed; exits with 1 where an answer differs.
"""

import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from environment import FOLDER, example, installed  # noqa: E402

# what Pinocchio's own CMake files define
DEFINITIONS = [
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
]
PACKAGES = ["pin==4.1.0", "cmeel-eigen==3.4.1", "mujoco==4.0.0"]


def instructions(command, calls):
    """Instructions of one call: the difference of two runs of different length."""
    counted = []
    for count in (calls, 3 * calls):
        valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        done = subprocess.run(valgrind + command(count), capture_output=True, text=True, check=True)
        counted.append(int(re.search(r"Collected : (\d+)", done.stderr)[1]))
    return (counted[1] - counted[0]) / (2 * calls)


def cost(python, chain):
    """Pinocchio's C++ and ours, in turn, on the same chain."""
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        print("cost SKIPPED: no C++ compiler")
        return
    where = "import pinocchio, pathlib; print(pathlib.Path(pinocchio.__file__).parents[4])"
    done = subprocess.run([python, "-c", where], capture_output=True, text=True, check=True)
    prefix = done.stdout.strip()
    program = FOLDER / "cost"
    source = HERE / "cost.cpp"
    compile_it = [compiler, "-std=c++17", "-O3", "-DNDEBUG", *DEFINITIONS, source, "-o", program]
    compile_it += ["-I", f"{prefix}/include", "-I", f"{prefix}/include/eigen3"]
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        print("compiling Pinocchio: minutes", flush=True)
        done = subprocess.run(compile_it, capture_output=True, text=True)
        if done.returncode != 0:
            errors = [line for line in done.stderr.splitlines() if "error" in line] or [done.stderr]
            print(f"cost SKIPPED: cost.cpp does not compile: {errors[0][:200]}")
            return
    ours = example("mrroc-robots", "dynamics_cost")
    theirs_by, ours_by = ({}, {})
    for _ in range(5):
        for program_of, best in (([program, chain], theirs_by), ([ours], ours_by)):
            done = subprocess.run([*program_of, "200000"], capture_output=True, text=True, check=True)
            for line in done.stdout.splitlines():
                name, ns = line.split()
                best[name] = min(best.get(name, float("inf")), float(ns))
    counting = shutil.which("valgrind") is not None
    print("\ncost of a call      Pinocchio ns  ours ns  ratio   Pinocchio Ir  ours Ir  ratio")
    for name in ("fk", "rnea", "crba", "forward"):
        line = f"{name:20}{theirs_by[name]:12.1f}{ours_by[name]:9.1f}{ours_by[name] / theirs_by[name]:7.3f}"
        if counting:
            theirs_ir = instructions(lambda n: [program, chain, str(n), name], 2000)
            ours_ir = instructions(lambda n: [ours, str(n), name], 2000)
            line += f"{theirs_ir:15.0f}{ours_ir:9.0f}{ours_ir / theirs_ir:7.3f}"
        print(line)


def main():
    python = installed(PACKAGES)
    oracle = example("mrroc-robots", "dynamics_oracle")
    compared = subprocess.run([python, HERE / "compare.py", oracle, FOLDER, *sys.argv[1:]])
    cost(python, FOLDER / "polycrank.chain")
    sys.exit(compared.returncode)


if __name__ == "__main__":
    main()
