"""Judges models by a JSON Schema: one JSON object per line on stdout, in the order of the files."""

import json
import sys
import tomllib

from jsonschema import Draft7Validator

with open(sys.argv[1], encoding="utf-8") as file:
    schema = json.load(file)
Draft7Validator.check_schema(schema)
validator = Draft7Validator(schema)
for path in sys.argv[2:]:
    with open(path, "rb") as file:
        model = tomllib.load(file)
    faults = [f"{'/'.join(map(str, e.absolute_path))}: {e.message}" for e in validator.iter_errors(model)]
    print(json.dumps({"file": path, "faults": faults}))
