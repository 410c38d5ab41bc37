"""What a step of the simulated Polycrank costs beside one of MuJoCo: the same links, from the URDF that
`robots::urdf` writes, the same rotors, friction, torques and substep of 0.25 ms.

python3 hil-sim/oracles/mujoco/run.py [ROUNDS]. Needs nothing but Python's standard library; what it fetches goes
into target/oracles. Prints SKIPPED with the reason, and exits with 0, where MuJoCo cannot be installed; exits with 1
where a step of ours is not at least twice as cheap as MuJoCo's cheapest.

Both run pinned to one processor, in turn, and count the time that processor worked for them; the medians are
compared. MuJoCo steps in its own C loop (`nstep`), without contacts, once without dry friction, which is less than we
do, and once with it. The two do not take the same trouble: MuJoCo evaluates the bodies in every step, we in every third and
continue them by a polynomial. So it also says how MuJoCo keeps the energy of the same free arm over 10 s; the tests of
`plant::rigid_body` say it of ours.
"""

import math
import os
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "robots" / "oracles"))

from environment import FOLDER, example, installed  # noqa: E402

PACKAGES = ["mujoco==4.0.0"]
STEP_S = 0.00025
STEPS = 20_000
GOAL = 2.0


def model(mujoco, urdf, axes, integrator, dry):
    spec = mujoco.MjSpec.from_string(urdf)
    spec.option.timestep = STEP_S
    spec.option.gravity = [0.0, 0.0, -9.80665]
    spec.option.integrator = integrator
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    for joint, (rotor, viscous, coulomb) in zip(spec.joints, axes, strict=True):
        # the Polycrank's cranks turn without end
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.armature = rotor
        joint.damping = [viscous, 0.0, 0.0]
        joint.frictionloss = coulomb if dry else 0.0
        motor = spec.add_actuator()
        motor.target = joint.name
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
    return spec.compile()


def drift(mujoco, numpy, model_of):
    """Greatest change of the energy over the greatest kinetic energy: 10 s from 1 rad off hanging, no friction.

    Kinetic with the rotors, which MuJoCo's own sum leaves out.
    """
    model_of.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data = mujoco.MjData(model_of)
    data.qpos[3] = 1.0 - math.pi / 2
    momentum = numpy.zeros(model_of.nv)

    def energies():
        mujoco.mj_forward(model_of, data)
        mujoco.mj_mulM(model_of, data, momentum, data.qvel)
        return 0.5 * data.qvel.dot(momentum), data.energy[0]

    begin = sum(energies())
    worst, most = 0.0, 0.0
    for _ in range(1000):
        mujoco.mj_step(model_of, data, nstep=40)
        kinetic, potential = energies()
        worst = max(worst, abs(kinetic + potential - begin))
        most = max(most, kinetic)
    return worst / most


def compare(rounds):
    import mujoco
    import numpy

    # where MuJoCo may write its log
    os.chdir(FOLDER)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    ours = example("mrroc-hil-sim", "arm_steps")
    oracle = example("mrroc-robots", "dynamics_oracle")
    ask = [oracle, "urdf", "polycrank"]
    urdf = subprocess.run(ask, capture_output=True, text=True, check=True).stdout
    told = subprocess.run([ours, "axes"], capture_output=True, text=True, check=True).stdout
    axes = [[float(number) for number in line.split()] for line in told.splitlines()]
    integrators = {"Euler": mujoco.mjtIntegrator.mjINT_EULER, "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST}
    models = {
        f"MuJoCo, {name}{', dry friction' if dry else ''}": model(mujoco, urdf, axes, integrator, dry)
        for dry in (False, True)
        for name, integrator in integrators.items()
    }
    costs = {name: [] for name in ["mrroc", *models]}
    for _ in range(rounds):
        for name, one in models.items():
            data = mujoco.MjData(one)
            took = 0.0
            for half in range(STEPS // 2000):
                data.ctrl[:] = 3.0 if half % 2 == 0 else -3.0
                since = time.process_time_ns()
                mujoco.mj_step(one, data, nstep=2000)
                took += time.process_time_ns() - since
            costs[name].append(took / STEPS)
        done = subprocess.run([ours, str(5 * STEPS)], capture_output=True, text=True, check=True)
        costs["mrroc"].append(float(done.stdout.split()[0]))
    medians = {name: statistics.median(cost) for name, cost in costs.items()}
    print(f"mujoco {mujoco.__version__}, a step of {STEP_S * 1e3} ms, {rounds} rounds, medians")
    for name, cost in medians.items():
        print(f"{name:36}{cost:8.0f} ns a step{1e9 / cost:12.0f} steps/s{cost / medians['mrroc']:8.2f}")
    for name in ("Euler", "implicitfast", "RK4"):
        integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{name.upper()}")
        free = [[rotor, 0.0, 0.0] for rotor, _, _ in axes]
        one = model(mujoco, urdf, free, integrator, dry=False)
        print(f"energy drift of MuJoCo, {name}: {drift(mujoco, numpy, one):.1e}")
    least = min(cost for name, cost in medians.items() if name != "mrroc")
    return least / medians["mrroc"]


def main():
    if len(sys.argv) > 1 and sys.argv[1] == "--compare":
        ratio = compare(int(sys.argv[2]))
        print(f"MuJoCo's cheapest step costs {ratio:.2f} of ours, the goal is {GOAL}")
        sys.exit(0 if ratio >= GOAL else 1)
    rounds = sys.argv[1] if len(sys.argv) > 1 else "9"
    sys.exit(subprocess.run([installed(PACKAGES), pathlib.Path(__file__).resolve(), "--compare", rounds]).returncode)


if __name__ == "__main__":
    main()
