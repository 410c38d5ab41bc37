"""Durations of motion::feed against toppra, on random paths of six joints. See README.md."""

import importlib.metadata
import random
import subprocess
import sys

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint

toppra.setup_logging("ERROR")

PATHS, JOINTS, SINES, LENGTH = 24, 6, 4, 4.0
VELOCITY, ACCELERATION, GRID = 1.0, 5.0, 0.002
COLUMNS = ["h 0.5 ms", "h 1 ms", "h 20 ms", "J, 1 ms", "J, 20 ms"]


def random_path(rng):
    """For each joint a slope and (amplitude, angular frequency, phase) of each sine."""
    return [
        (
            rng.uniform(-1, 1),
            [(rng.uniform(-1, 1) / (k + 1), rng.uniform(0, 3) * (k + 1), rng.uniform(0, 6.28)) for k in range(SINES)],
        )
        for _ in range(JOINTS)
    ]


class Fourier(toppra.interpolator.AbstractGeometricPath):
    """The path with exact derivatives."""

    def __init__(self, path):
        self.path = path

    def __call__(self, s, order=0):
        s = np.atleast_1d(s)
        joints = []
        for slope, sines in self.path:
            x = [slope * s, slope + 0 * s, 0 * s][order]
            for amplitude, w, phase in sines:
                x = x + amplitude * w**order * np.sin(w * s + phase + order * np.pi / 2)
            joints.append(x)
        out = np.array(joints).T
        return out if out.shape[0] > 1 else out[0]

    @property
    def dof(self):
        return JOINTS

    @property
    def path_interval(self):
        return np.array([0.0, LENGTH])


def toppra_time(path):
    """Seconds of the time-optimal parameterization on the same grid."""
    grid = np.linspace(0, LENGTH, int(round(LENGTH / GRID)) + 1)
    box = np.ones((JOINTS, 1)) * np.array([[-1.0, 1.0]])
    constraints = [
        toppra.constraint.JointVelocityConstraint(VELOCITY * box),
        toppra.constraint.JointAccelerationConstraint(
            ACCELERATION * box, discretization_scheme=toppra.constraint.DiscretizationType.Interpolation
        ),
    ]
    instance = toppra.algorithm.TOPPRA(constraints, Fourier(path), gridpoints=grid)
    _, speed, _ = instance.compute_parameterization(0, 0)
    return np.sum(2 * np.diff(grid) / (speed[1:] + speed[:-1]))


def main():
    rng = random.Random(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    paths = [random_path(rng) for _ in range(PATHS)]
    lines = [
        " ".join(map(repr, [LENGTH] + [x for slope, sines in path for x in [slope] + [y for sine in sines for y in sine]]))
        for path in paths
    ]
    ours = subprocess.run([sys.argv[1]], input="\n".join(lines), text=True, capture_output=True, check=True).stdout
    print("toppra", importlib.metadata.version("toppra"))
    print("path  toppra s " + " ".join(f"{c:>9}" for c in COLUMNS) + "   (ours/toppra)")
    ratios = []
    for i, (path, line) in enumerate(zip(paths, ours.splitlines())):
        best = toppra_time(path)
        ratios.append([float(x) / best for x in line.split()])
        print(f"{i:4}  {best:8.4f} " + " ".join(f"{r:9.4f}" for r in ratios[-1]))
    ratios = np.array(ratios)
    for name, row in [("mean", ratios.mean(axis=0)), ("worst", ratios.max(axis=0)), ("best", ratios.min(axis=0))]:
        print(f"{name:>14} " + " ".join(f"{r:9.4f}" for r in row))


if __name__ == "__main__":
    main()
