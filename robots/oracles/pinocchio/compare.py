"""Our answers to random states against Pinocchio's and MuJoCo's on the exported URDF. `run.py` calls it.

compare.py ORACLE FOLDER [COUNT [SEED]]. Errors, the greatest over all states:

  FK       of the flange: m, and entries of the rotation
  RNEA     of torques, over max|tau| + max|M| max|qdd| of the state: the terms that rounding is relative to
  CRBA     over the greatest entry of the mass matrix
  FD       of accelerations, over 1 + the greatest of the state
"""

import importlib.metadata
import subprocess
import sys

import mujoco
import numpy as np
import pinocchio as pin

CHAINS = {"irp6-track": 7, "irp6-postument": 6, "irp6-arm": 5, "polycrank": 7, "rnt": 6}
TOLERANCE = 1e-12
GRAVITY = np.array([0.0, 0.0, -9.80665])


def split(line, n):
    """The fields of a line of `dynamics_oracle answers`."""
    numbers = np.array([float(x) for x in line.split()])
    sizes = [n, n, n, 3, 3, n, 3, 9, n, n * n, n]
    assert len(numbers) == sum(sizes), len(numbers)
    return np.split(numbers, np.cumsum(sizes)[:-1])


class Worst(dict):
    """The greatest value of each name; NaN stays."""

    def add(self, name, value):
        old = self.get(name, 0.0)
        self[name] = value if not value <= old else old


def with_pinocchio(worst, model, data, state):
    n = model.nv
    q, dq, ddq, force, moment, tau, position, rotation, torques, matrix, accelerations = state
    frame = model.frames[model.getFrameId("flange")]
    pin.forwardKinematics(model, data, q)
    flange = pin.updateFramePlacement(model, data, model.getFrameId("flange"))
    worst.add("FK", np.abs(flange.translation - position).max())
    worst.add("FK", np.abs(flange.rotation - rotation.reshape(3, 3).T).max())
    external = pin.StdVec_Force([pin.Force.Zero()] * model.njoints)
    external[frame.parentJoint] = frame.placement.act(pin.Force(force, moment))
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    heaviest = np.abs(mass).max()
    theirs = pin.rnea(model, data, q, dq, ddq, external)
    scale = np.abs(theirs).max() + heaviest * np.abs(ddq).max()
    worst.add("RNEA", np.abs(theirs - torques).max() / scale)
    worst.add("CRBA", np.abs(mass - matrix.reshape(n, n)).max() / heaviest)
    theirs = pin.aba(model, data, q, dq, tau, external)
    worst.add("FD", np.abs(theirs - accelerations).max() / (1 + np.abs(theirs).max()))


def with_mujoco(worst, model, data, state):
    n = model.nv
    q, dq, ddq, force, moment, _, position, rotation, torques, matrix, _ = state
    data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
    mujoco.mj_inverse(model, data)
    # what pushes at the flange, by its Jacobian
    axes = rotation.reshape(3, 3).T
    jacobian = np.zeros((2, 3, n))
    last = model.nbody - 1
    mujoco.mj_jac(model, data, jacobian[0], jacobian[1], position, last)
    pushed = jacobian[0].T @ (axes @ force) + jacobian[1].T @ (axes @ moment)
    theirs = data.qfrc_inverse - pushed
    mass = np.zeros((n, n))
    mujoco.mj_fullM(model, data, mass)
    heaviest = np.abs(mass).max()
    scale = np.abs(theirs).max() + heaviest * np.abs(ddq).max()
    worst.add("MuJoCo inverse", np.abs(theirs - torques).max() / scale)
    worst.add("MuJoCo M", np.abs(mass - matrix.reshape(n, n)).max() / heaviest)


def write_plain(model, path):
    """The model for cost.cpp: a line a joint, its letter, placement (rotation by rows), mass, centre, inertia."""
    with open(path, "w", encoding="utf-8") as file:
        for k in range(1, model.njoints):
            placement, body = model.jointPlacements[k], model.inertias[k]
            numbers = [*placement.rotation.flatten(), *placement.translation, body.mass, *body.lever]
            numbers += list(body.inertia.flatten())
            letter = "P" if "P" in model.joints[k].shortname() else "R"
            file.write(" ".join([letter, *map(repr, map(float, numbers))]) + "\n")


def main():
    oracle, folder = sys.argv[1:3]
    count, seed = (sys.argv[3:] + ["10000", "1"][len(sys.argv[3:]) :])[:2]
    version = importlib.metadata.version
    print(f"pin {version('pin')}, mujoco {version('mujoco')}; {count} states of seed {seed}")
    differs = False
    for name, n in CHAINS.items():
        urdf = subprocess.run([oracle, "urdf", name], capture_output=True, text=True, check=True).stdout
        with open(f"{folder}/{name}.urdf", "w", encoding="utf-8") as file:
            file.write(urdf)
        model = pin.buildModelFromXML(urdf)
        model.gravity.linear = GRAVITY
        write_plain(model, f"{folder}/{name}.chain")
        other = mujoco.MjModel.from_xml_string(urdf)
        other.opt.gravity[:] = GRAVITY
        other.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        assert model.nv == other.nv == n, (model.nv, other.nv)
        data, other_data, worst = model.createData(), mujoco.MjData(other), Worst()
        asked = [oracle, "answers", name, count, seed]
        answers = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
        for line in answers.splitlines():
            state = split(line, n)
            with_pinocchio(worst, model, data, state)
            with_mujoco(worst, other, other_data, state)
        print(f"{name:15}" + "  ".join(f"{key} {value:.1e}" for key, value in worst.items()))
        differs |= any(not value < TOLERANCE for value in worst.values())
    print(f"{'DIFFERENT' if differs else 'equal'} to {TOLERANCE}")
    sys.exit(differs)


if __name__ == "__main__":
    main()
