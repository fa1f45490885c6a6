#!/usr/bin/env bash
# What the tests need beside Rust, a C++ compiler, Python and Node.js: Python packages that draw, read
# and judge files, a browser for pages, a virtual display for the window, and a graphics adapter in
# software where there is no card. On Debian and Ubuntu it installs what is missing; elsewhere it
# says what to install.
set -euo pipefail
cd "$(dirname "$0")/.."

python3 -m venv target/venv
target/venv/bin/pip install -q -r tests/requirements.txt
# Pyright fetches its own program when it first runs.
target/venv/bin/python -m pyright --version >/dev/null

missing=()
has() { command -v "$1" >/dev/null; }
has npm || missing+=(nodejs npm)
has unzip || missing+=(unzip)
has chromium || missing+=(chromium)
has Xvfb || missing+=(xvfb)
has xdotool || missing+=(xdotool)
ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1 || missing+=(mesa-vulkan-drivers)
libraries=$(/sbin/ldconfig -p 2>/dev/null || true)
grep -q libvulkan.so.1 <<<"$libraries" || missing+=(libvulkan1)
grep -q libxkbcommon-x11.so.0 <<<"$libraries" || missing+=(libxkbcommon-x11-0)

if [ ${#missing[@]} -gt 0 ]; then
    if ! has apt-get; then
        echo "install these, or what they are called on this system: ${missing[*]}" >&2
        exit 1
    fi
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=300 update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 \
        install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi
