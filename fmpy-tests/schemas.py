"""The JSON Schemas of the program, and validation of its output against them."""

import json
import subprocess
from functools import lru_cache

from jsonschema import Draft202012Validator

from own_program import PROGRAM


@lru_cache(maxsize=None)
def validator(command):
    text = subprocess.run([str(PROGRAM), "schema", command], capture_output=True, text=True, check=True).stdout
    schema = json.loads(text)
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def names():
    return subprocess.run([str(PROGRAM), "schema"], capture_output=True, text=True, check=True).stdout.split()


def check(command, value):
    """Fails with the first places at which a value does not conform to the schema of its command."""
    errors = [f"{error.json_path}: {error.message[:300]}" for error in validator(command).iter_errors(value)]
    assert not errors, f"{command}: {errors[:5]}"
    return value
