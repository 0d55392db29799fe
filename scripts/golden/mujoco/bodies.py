"""Forces of the joints of a crane, as MuJoCo's inverse dynamics has them: crates/bodies/tests/golden/crane.json.

Needs `pip install mujoco numpy`. Licence of the tool: Apache-2.0.
"""

import json
import pathlib

import mujoco
import numpy as np

GOLDEN = pathlib.Path(__file__).parents[3] / "crates" / "bodies" / "tests" / "golden"


def main() -> None:
    """Computes and writes."""
    model = mujoco.MjModel.from_xml_path(str(GOLDEN / "crane.xml"))
    data, rng, states = mujoco.MjData(model), np.random.default_rng(0), []
    for _ in range(20):
        q, v, a = rng.uniform(-1.5, 1.5, model.nq), rng.uniform(-2, 2, model.nv), rng.uniform(-5, 5, model.nv)
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        states.append({"q": q.tolist(), "v": v.tolist(), "a": a.tolist(), "forces": data.qfrc_inverse.tolist()})
    text = {"tool": f"MuJoCo {mujoco.__version__}", "command": "python scripts/golden/mujoco/bodies.py", "tolerance": 1e-9, "states": states}
    (GOLDEN / "crane.json").write_text(json.dumps(text, indent=1) + "\n")


if __name__ == "__main__":
    main()
