#!/usr/bin/env bash
# The addon in FreeCAD: without a window, and in one where there is `xvfb-run`. Where FreeCAD is not installed
# nothing is tested, and a line says so.
#
#     editors/freecad/test.sh [BKSIM]     the command to test with; else that of the variable BKSIM, or of target/
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
console=$(command -v freecadcmd || command -v FreeCADCmd || true)
window=$(command -v freecad || command -v FreeCAD || true)
if [ -z "$console" ]; then
    echo "editors/freecad: FreeCAD isn't installed, nothing is tested"
    exit 0
fi
bksim=${1:-${BKSIM:-}}
if [ -z "$bksim" ]; then
    (cd "$root" && cargo build --quiet --workspace --bin bksim --bin bksim-studio)
    bksim=$root/target/debug/bksim
fi
BKSIM=$(realpath "$bksim")
export BKSIM

# A home of its own, with the addon where the addon manager would put it.
home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
mkdir -p "$home/Mod" "$home/pictures"
ln -s "$here" "$home/Mod/bksim"
cat >"$home/user.cfg" <<'CONFIG'
<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<FCParameters><FCParamGroup Name="Root"><FCParamGroup Name="BaseApp"><FCParamGroup Name="Preferences">
<FCParamGroup Name="General"><FCText Name="AutoloadModule">PartWorkbench</FCText></FCParamGroup>
</FCParamGroup></FCParamGroup></FCParamGroup></FCParameters>
CONFIG
export FREECAD_USER_HOME=$home PICTURES=${PICTURES:-$home/pictures} PYTHONDONTWRITEBYTECODE=1

# FreeCAD's own exit status says nothing of a script, so the scripts say that they have passed.
judged() {
    local name=$1 log=$home/$1.log
    shift
    "$@" </dev/null >"$log" 2>&1 || true
    if ! grep -q "$name: passed" "$log"; then
        grep -v '%)' "$log" >&2
        echo "editors/freecad: $name failed" >&2
        exit 1
    fi
    grep -o "$name: passed.*" "$log"
}

judged headless timeout 300 "$console" "$here/tests/headless.py"
if [ -n "$window" ] && command -v xvfb-run >/dev/null; then
    judged window timeout 300 xvfb-run -a -s "-screen 0 1600x1000x24" \
        "$window" -u "$home/user.cfg" "$here/tests/window.py"
else
    echo "editors/freecad: without xvfb-run the window isn't tested"
fi
