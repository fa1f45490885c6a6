#!/usr/bin/env bash
# The Python package as a new user comes to it: the two lines of its README in an environment that has
# nothing else, then its notebook with what that asks for.
set -euo pipefail
cd "$(dirname "$0")/.."

python3 -m venv --clear target/clean
export PATH="$PWD/target/clean/bin:$PATH"
lines=$(grep -A1 -m1 '^pip install' crates/py/README.md)
echo "$lines"
eval "$lines"

grep -E '^(ipykernel|nbclient|pandas|pytest)=' tests/requirements.txt >target/clean/notebook.txt
pip install -q -r target/clean/notebook.txt
python -m pytest -q -p no:cacheprovider crates/py/tests/test_notebook.py
