"""Steps an exported model in MuJoCo: exported.xml, name, command.csv, step [s], positions.txt."""

import pathlib
import sys

import mujoco

exported, name, commands, step, positions = sys.argv[1:]
rows = [tuple(map(float, row.split(",")[:2])) for row in pathlib.Path(commands).read_text().splitlines()[1:]]
model = mujoco.MjModel.from_xml_path(exported)
data = mujoco.MjData(model)
written, done = [], 0
for (time, command), following in zip(rows, rows[1:] + [None]):
    written.append(data.qpos[0])
    if following is None:
        break
    data.ctrl[0] = command
    until = round((following[0] - rows[0][0]) / model.opt.timestep)
    if until > done:
        mujoco.mj_step(model, data, until - done)
    done = until
pathlib.Path(positions).write_text("\n".join(f"{value:.17g}" for value in written))
print(f"MuJoCo {mujoco.__version__}, steps of {model.opt.timestep} s")
