"""Writes examples/robots/arm.csv: the motion of an arm with known parameters in MuJoCo, with noise.

The arm is that of examples/robots/arm.urdf with the parameters below, which that file does not have. Needs `pip install mujoco numpy`.
"""

import pathlib
import re

import mujoco
import numpy as np

FOLDER = pathlib.Path(__file__).parent.parent / "examples" / "robots"
# Mass [kg], center of mass [m], inertia about it [kg m²] of each link, and damping [N m s/rad; N s/m] of its joint.
TRUE = {
    "column": (4.2, (0.01, -0.02, 0.12), (0.031, 0.029, 0.014), 0.5),
    "beam": (2.6, (0.22, 0.0, 0.015), (0.004, 0.052, 0.053), 0.8),
    "forearm": (1.1, (0.14, 0.01, 0.0), (0.0012, 0.013, 0.0134), 0.3),
}
ROWS, DT, NOISE = 600, 0.02, 0.002


def true_urdf(text: str) -> str:
    """The file with the true parameters."""
    for link, (mass, com, inertia, damping) in TRUE.items():
        xyz = " ".join(map(str, com))
        inertial = (
            f'<inertial><origin xyz="{xyz}"/><mass value="{mass}"/>'
            f'<inertia ixx="{inertia[0]}" ixy="0" ixz="0" iyy="{inertia[1]}" iyz="0" izz="{inertia[2]}"/></inertial>'
        )
        text = re.sub(rf'<link name="{link}">.*?</link>', f'<link name="{link}">{inertial}</link>', text, flags=re.S)
        joint = rf'(<child link="{link}"/>.*?<dynamics damping=")[^"]*'
        text = re.sub(joint, rf"\g<1>{damping}", text, flags=re.S)
    return text.replace("</robot>", '<mujoco><compiler balanceinertia="false"/></mujoco></robot>')


def main() -> None:
    """Simulates and writes."""
    rng = np.random.default_rng(0)
    model = mujoco.MjModel.from_xml_string(true_urdf((FOLDER / "arm.urdf").read_text()))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 0.001
    data, n = mujoco.MjData(model), model.nv
    names = [model.joint(i).name for i in range(n)]
    rest = np.array([0.0, 0.3, 0.8])
    data.qpos[:] = rest
    frequency, phase = rng.uniform(0.2, 1.1, (n, 4)), rng.uniform(0, 2 * np.pi, (n, 4))
    q, v, u = [], [], []
    for row in range(ROWS):
        wave = np.sin(2 * np.pi * frequency * row * DT + phase) * [0.5, 0.35, 0.25, 0.2]
        mujoco.mj_forward(model, data)
        mass = np.zeros((n, n))
        mujoco.mj_fullM(model, data, mass)
        torque = 0.95 * data.qfrc_bias + mass @ (40 * (rest + wave.sum(1) - data.qpos) - 6 * data.qvel)
        q.append(data.qpos.copy())
        v.append(data.qvel.copy())
        u.append(torque)
        data.qfrc_applied[:] = torque
        for _ in range(round(DT / model.opt.timestep)):
            mujoco.mj_step(model, data)
    q, v, u = np.array(q), np.array(v), np.array(u)
    q += NOISE * q.std(0) * rng.standard_normal(q.shape)
    v += NOISE * v.std(0) * rng.standard_normal(v.shape)
    header = ["t", *(f"{name}_position" for name in names), *(f"{name}_velocity" for name in names), *(f"{name}_torque" for name in names)]
    table = np.column_stack([np.arange(ROWS) * DT, q, v, u])
    np.savetxt(FOLDER / "arm.csv", table, delimiter=",", header=",".join(header), comments="", fmt="%.7g")


if __name__ == "__main__":
    main()
