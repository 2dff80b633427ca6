"""Steps an exported system in JSBSim, inside a body that is not flown: exported.xml, name, command.csv, frame [s], positions.txt."""

import os
import pathlib
import sys

exported, name, commands, frame, positions = sys.argv[1:]
rows = [tuple(map(float, row.split(",")[:2])) for row in pathlib.Path(commands).read_text().splitlines()[1:]]
root = pathlib.Path(exported).parent
systems = root / "aircraft" / "rig" / "Systems"
systems.mkdir(parents=True)
(systems / "exported.xml").write_text(pathlib.Path(exported).read_text())
place = '<x>0</x><y>0</y><z>0</z></location>'
inertia = "".join(f'<{axis} unit="SLUG*FT2">1</{axis}>' for axis in ("ixx", "iyy", "izz"))
(root / "aircraft" / "rig" / "rig.xml").write_text(
    f"""<?xml version="1.0"?>
<fdm_config name="rig" version="2.0" release="ALPHA">
 <fileheader><author/><filecreationdate>2000-01-01</filecreationdate><version>1</version><description/></fileheader>
 <metrics><wingarea unit="FT2">1</wingarea><wingspan unit="FT">1</wingspan><chord unit="FT">1</chord>
  <location name="AERORP" unit="IN">{place}<location name="EYEPOINT" unit="IN">{place}<location name="VRP" unit="IN">{place}</metrics>
 <mass_balance>{inertia}<emptywt unit="LBS">1</emptywt><location name="CG" unit="IN">{place}</mass_balance>
 <ground_reactions/><propulsion/><system file="exported"/><aerodynamics/>
</fdm_config>"""
)
silent = os.open(os.devnull, os.O_WRONLY)
terminal = os.dup(1)
os.dup2(silent, 1)  # it prints a banner
import jsbsim  # noqa: E402

simulation = jsbsim.FGFDMExec(str(root), None)
simulation.set_debug_level(0)
simulation.set_dt(float(frame))
simulation.load_model("rig")
simulation["ic/h-sl-ft"] = 1e5
simulation.run_ic()
written, done = [], 0
for (time, command), following in zip(rows, rows[1:] + [None]):
    written.append(simulation["actuator/position"])
    if following is None:
        break
    simulation["actuator/command"] = command
    until = round((following[0] - rows[0][0]) / float(frame))
    for _ in range(until - done):
        simulation.run()
    done = until
pathlib.Path(positions).write_text("\n".join(f"{value:.17g}" for value in written))
os.dup2(terminal, 1)
print(f"JSBSim {jsbsim.__version__}, frames of {frame} s")
