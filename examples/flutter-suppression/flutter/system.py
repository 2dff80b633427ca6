"""The pair as an SSP: two components, two connections, parameter values bound to each component under their plain names.

Names without prefix, bound at the component, and no connectors of the system itself: libcosim, Ecos and OMSimulator all
apply these. Both hosts use Jacobi stepping with a step size of their choice, so `prediction` of the wing should be that step.
"""

import json
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from flutter import EXAMPLE, loop

NAME = "flutter-suppression"
HOSTS = {"libcosim": EXAMPLE / "run_in_libcosim.py", "Ecos": EXAMPLE / "run_in_ecos.py"}
NOT_HERE = 77  # exit code of a host that cannot be loaded here
PARAMETER_SET = "start"  # the same name for both components: Ecos applies one set, by its name
PATIENCE_S = 120
STAMP = (1998, 7, 1, 0, 0, 0)  # of every file in the archive: the same archive for the same content
CONNECTORS = {
    "actuator": {"command": "input", "deflection": "output"},
    "wing": {"deflection": "input", "pitch": "output", "plunge": "output", "command": "output"},
}
CONNECTIONS = (("wing", "command", "actuator", "command"), ("actuator", "deflection", "wing", "deflection"))
NAMESPACES = " ".join(
    f'xmlns:{short}="http://ssp-standard.org/SSP1/{long}"'
    for short, long in (
        ("ssd", "SystemStructureDescription"),
        ("ssc", "SystemStructureCommon"),
        ("ssv", "SystemStructureParameterValues"),
    )
)
WATCHED = (("wing", "plunge"), ("wing", "pitch"), ("wing", "command"), ("actuator", "deflection"))


def write(path, fmus, parameters):
    """Writes the SSP: `fmus` and `parameters` map component names to FMU files and {variable: number}."""
    files = {"SystemStructure.ssd": _structure(fmus)}
    files |= {f"resources/{component}.ssv": _values(values) for component, values in parameters.items()}
    files |= {f"resources/{Path(fmu).name}": Path(fmu).read_bytes() for fmu in fmus.values()}
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, STAMP)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, content)
    return path


def _structure(fmus):
    components = "".join(
        f"""
      <ssd:Component name="{component}" type="application/x-fmu-sharedlibrary" source="resources/{Path(fmu).name}">
        <ssd:Connectors>
{"".join(_connector(name, kind) for name, kind in CONNECTORS[component].items())}        </ssd:Connectors>
        <ssd:ParameterBindings>
          <ssd:ParameterBinding type="application/x-ssp-parameter-set" source="resources/{component}.ssv"/>
        </ssd:ParameterBindings>
      </ssd:Component>"""
        for component, fmu in fmus.items()
    )
    connections = "".join(
        f'\n      <ssd:Connection startElement="{a}" startConnector="{x}" endElement="{b}" endConnector="{y}"/>'
        for a, x, b, y in CONNECTIONS
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription {NAMESPACES} version="1.0" name="{NAME}">
  <ssd:System name="{NAME}">
    <ssd:Elements>{components}
    </ssd:Elements>
    <ssd:Connections>{connections}
    </ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
"""


def _connector(name, kind):
    return f'          <ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>\n'


def _values(values):
    def line(name, value):
        kind = "Integer" if isinstance(value, int) else "Real"
        return f'    <ssv:Parameter name="{name}"><ssv:{kind} value="{value!r}"/></ssv:Parameter>\n'

    lines = "".join(line(name, value) for name, value in values.items())
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet {NAMESPACES} version="1.0" name="{PARAMETER_SET}">
  <ssv:Parameters>
{lines}  </ssv:Parameters>
</ssv:ParameterSet>
"""


def run_in(host, ssp, duration_s, step_s=loop.STEP_S):
    """The loop as run by this host, or None if the host cannot be loaded.

    In a separate process and folder: both hosts end with a segmentation fault when an FMU does not load, and do not remove
    the files that they unpacked.
    """
    job = {
        "ssp": str(ssp),
        "step_s": step_s,
        "steps": round(duration_s / step_s),
        "watched": WATCHED,
        "parameter_set": PARAMETER_SET,
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "job.json"
        file.write_text(json.dumps(job))
        run = subprocess.run(
            [sys.executable, "-B", str(HOSTS[host]), str(file)],
            capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ, "TMPDIR": folder}, cwd=folder,
        )  # fmt: skip
    if run.returncode == NOT_HERE:
        return None
    if run.returncode != 0:
        raise RuntimeError(f"{host}: exit code {run.returncode}\n{run.stdout}\n{run.stderr}")
    rows = np.array(json.loads(run.stdout.splitlines()[-1]))
    return loop.Response(step_s * np.arange(1, len(rows) + 1), *rows.T)
