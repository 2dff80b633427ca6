"""Measured actuators as FMI 2.0 units.

>>> import actuator_fmu
>>> actuator_fmu.fmu_path()                                     # BactActuator.fmu, for FMPy and other importers
>>> fit = actuator_fmu.fit(["sweep.csv", "random.csv"])         # k, p, omega, zeta with their standard errors
>>> found = actuator_fmu.diagnose(fit, ["sweep.csv"], check=["random.csv"])
>>> found.verdict, found.sentence

Everything is computed by the program `actuator`, which is on the PATH as well; this package writes arrays and frames to its files, and
converts its JSON to dataclasses.
"""

from ._diagnose import Candidate, Diagnosis, Effect, Gap, Gaps, Parameter, Place, diagnose
from ._fit import Estimate, Fit, fit
from ._program import ActuatorError, fmu_path, program_path, version
from ._sets import ParameterSet, Quantity, sets
from ._simulate import Response, simulate

__version__ = version()

__all__ = [
    "ActuatorError",
    "Candidate",
    "Diagnosis",
    "Effect",
    "Estimate",
    "Fit",
    "Gap",
    "Gaps",
    "Parameter",
    "ParameterSet",
    "Place",
    "Quantity",
    "Response",
    "diagnose",
    "fit",
    "fmu_path",
    "program_path",
    "sets",
    "simulate",
    "version",
]
