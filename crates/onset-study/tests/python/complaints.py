"""What a validator complains about in each document of {"schema": ..., "documents": [...]} on standard input."""

import json
import sys

from jsonschema import Draft202012Validator

question = json.load(sys.stdin)
Draft202012Validator.check_schema(question["schema"])
validator = Draft202012Validator(question["schema"])
print(json.dumps([[f"{error.json_path}: {error.message}" for error in validator.iter_errors(document)] for document in question["documents"]]))
