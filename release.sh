#!/usr/bin/env bash
# A release for this machine, in target/release-files: one wheel for every Python from 3.10 on (abi3), and the
# programs, stripped, with their licences in one archive. On Linux the wheel is marked with the oldest glibc that it
# runs on (manylinux), and `bksim` is linked statically, so that it runs on any distribution; `bksim-studio` opens
# the graphics drivers of the system and is not. .github/workflows/release.yml runs it on Linux, macOS and Windows.
#
#     ./release.sh            all
#     ./release.sh wheel      the wheel alone
#     ./release.sh programs   the programs alone
#     ./release.sh extension  the extension of VS Code alone, which serves every machine
#
# BKSIM_PROFILE=dev builds in the profile of the tests, to try the script.
set -euo pipefail
cd "$(dirname "$0")"
part=${1:-all}
profile=${BKSIM_PROFILE:-dist}
folder=$([ "$profile" = dev ] && echo debug || echo "$profile")
host=$(rustc -vV | sed -n 's/^host: //p')
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)
out=$PWD/target/release-files
mkdir -p "$out"

wheel() {
    python3 -m venv target/release-venv
    local bin=target/release-venv/bin
    [ -d "$bin" ] || bin=target/release-venv/Scripts
    "$bin/pip" install -q 'maturin>=1.9,<2'
    # The package takes the module of live pages along, where it can be built.
    local module=crates/py/python/bksim/bksim_live.wasm
    live_module "$module"
    "$bin/maturin" build --profile "$profile" --manifest-path crates/py/Cargo.toml --out "$out"
    rm -f "$module"
}

# The module of live pages, where this compiler has the standard library of its target.
live_module() {
    local target=wasm32-unknown-unknown
    if [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; then
        echo "left out: bksim_live.wasm, for live pages; rustup target add $target" >&2
        return
    fi
    cargo build -p bksim-live --profile live --target "$target"
    cp "target/$target/live/bksim_live.wasm" "$1"
}

programs() {
    local staged=target/bksim-$version-$host suffix=
    case $host in
    *windows*) suffix=.exe ;;
    *linux-gnu)
        # A target of its own, so that nothing that runs while building is linked statically.
        RUSTFLAGS="-C target-feature=+crt-static" cargo build --profile "$profile" --target "$host" -p bksim-cli
        ;;
    esac
    cargo build --profile "$profile" -p bksim-cli -p bksim-studio
    rm -rf "$staged" && mkdir -p "$staged"
    cp "target/$folder/bksim-studio$suffix" README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE NOTICES.md "$staged"
    local static=target/$host/$folder/bksim
    [ -f "$static" ] || static=target/$folder/bksim$suffix
    cp "$static" "$staged/bksim$suffix"
    live_module "$staged"
    tar -C target -czf "$out/bksim-$version-$host.tar.gz" "$(basename "$staged")"
}

# The extension of VS Code, where there is Node.js.
extension() {
    if ! command -v npm >/dev/null; then
        echo "left out: the extension of VS Code, which needs Node.js" >&2
        return
    fi
    cp LICENSE-MIT LICENSE-APACHE editors/vscode
    (cd editors/vscode && npm ci --silent --no-audit --no-fund && npm run --silent package)
    cp editors/vscode/bksim.vsix "$out/bksim-$version.vsix"
}

case $part in
all) wheel && programs && extension ;;
wheel) wheel ;;
programs) programs ;;
extension) extension ;;
*) echo "what to release: all, wheel, programs or extension; not $part" >&2 && exit 2 ;;
esac
ls -l "$out"
