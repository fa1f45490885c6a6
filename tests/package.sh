#!/usr/bin/env bash
# The Python package as a new user comes to it: the two lines of its README in an environment that has
# nothing else, then its notebook with what that asks for. Built in the profile of the tests, which is
# there already; BKSIM_PROFILE=release builds it as those lines do by themselves.
set -euo pipefail
cd "$(dirname "$0")/.."

python3 -m venv --clear target/clean
export PATH="$PWD/target/clean/bin:$PATH"
export MATURIN_PEP517_ARGS="--profile ${BKSIM_PROFILE:-dev}"
lines=$(grep -A1 -m1 '^pip install' crates/py/README.md)
echo "$lines"
eval "$lines"
bksim info --help >/dev/null

grep -E '^(anywidget|ipykernel|nbclient|pandas|pytest)=' tests/requirements.txt >target/clean/notebook.txt
pip install -q -r target/clean/notebook.txt
python -m pytest -q -p no:cacheprovider crates/py/tests/test_notebook.py

# The wheel of a release, in an environment that has nothing else.
BKSIM_PROFILE=${BKSIM_PROFILE:-dev} ./release.sh wheel
python3 -m venv --clear target/clean
pip install -q target/release-files/bksim-*.whl
bksim --version
python -c "import bksim; bksim.load('examples/slider-crank/model.toml').solve(t_end=0.1)"
