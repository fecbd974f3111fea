"""
16. Watched in MuJoCo
=====================

A cart in MuJoCo carries a vase. Between two steps the monitor takes the cart's acceleration and the poses on it, and
the motor yields while the margin is small. Without MuJoCo this example says so and ends.
"""

import importlib
import importlib.util

import numpy as np

import holdfast as hf

MODEL = """
<mujoco>
  <option timestep="0.002" cone="elliptic"/>
  <worldbody>
    <body name="cart">
      <joint name="drive" type="slide" axis="1 0 0"/>
      <geom type="box" size="0.4 0.3 0.02" pos="0 0 -0.02" mass="20" friction="0.6"/>
    </body>
    <body name="vase" pos="0 0 0.15">
      <freejoint/>
      <geom type="cylinder" size="0.04 0.15" mass="1.2" friction="0.6"/>
    </body>
  </worldbody>
  <actuator><motor joint="drive"/></actuator>
</mujoco>
"""
EVERY = 10  # steps of 2 ms between two updates
WANTED = 4.0  # m/s² that the cart is asked for


def drive(careful: bool) -> hf.answers.Assembly:
    """Half a second, from rest: full thrust, or as much as leaves a margin of a quarter. Returns what was carried."""
    mujoco = importlib.import_module("mujoco")
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 200)
    # what has no free joint is the carrier; soft contacts overlap by tenths of a millimetre, and lean by degrees
    soft = hf.assemble(hf.from_mujoco(model, data), gap=0.001, angle_degrees=5)
    monitor = hf.Monitor(soft, seconds=2.0)  # plenty of time: poses that moved take more than questions
    start, mass = data.qpos[0], sum(model.body_mass)
    margins, seconds = [1.0], []
    for k in range(250):
        if k % EVERY == 0 and margins[-1] > 0:
            mujoco.mj_forward(model, data)
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = data.xmat[2].reshape(3, 3), data.xpos[2]
            pose[0, 3] -= data.qpos[0] - start  # in the axes that move with the cart
            now = monitor.update((data.qacc[0], 0, 0), poses={"vase": pose})
            margins.append(now.margin)
            seconds.append(now.seconds)
            wanted = WANTED
            while careful and wanted > 0.1 and monitor.update((wanted, 0, 0)).margin < 0.25:
                wanted *= 0.9
            data.ctrl[0] = wanted * mass
        mujoco.mj_step(model, data)
    vase = "stands" if data.xmat[2][8] > 0.9 else "has fallen"
    print(f"margin at least {min(margins):.2f}; after half a second the vase {vase}, the cart drives ", end="")
    print(f"{data.qvel[0]:.2f} m/s; the median update took {1e3 * np.median(seconds):.1f} ms")
    return monitor.assembly


if importlib.util.find_spec("mujoco") is None:
    print("skipped: MuJoCo is not installed (pip install mujoco)")
else:
    for careful in (False, True):
        print("with care: " if careful else "full thrust: ", end="")
        carried = drive(careful)
