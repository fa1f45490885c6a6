#!/usr/bin/env bash
# Builds, packages and tests the extension: with the command that BKSIM names, else the one of the last build.
set -euo pipefail
cd "$(dirname "$0")"
export BKSIM=${BKSIM:-$PWD/../../target/debug/bksim}

[ -d node_modules ] || npm ci --silent --no-audit --no-fund
node scripts/generate.mjs --check
cp ../../LICENSE-MIT ../../LICENSE-APACHE .
rm -f bksim.vsix
npm run --silent package
npm run --silent test
