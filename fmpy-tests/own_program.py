"""The program `actuator` under test."""

import os

from actuator_fmu import REPOSITORY

PROGRAM = REPOSITORY / os.environ.get("ACTUATOR_PROGRAM", "target/debug/actuator")
