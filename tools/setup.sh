#!/bin/sh
# Sets up all that reflet needs, once: `tools/setup.sh python|web|browser`. Called by the Makefile.
# System packages come from the distribution where they are missing and we may install them;
# otherwise one sentence says what to install, and the script ends with status 2.
set -eu
cd "$(dirname "$0")/.."

say() { printf 'reflet setup: %s\n' "$*" >&2; }

libraries() {
    { ldconfig -p || /sbin/ldconfig -p; } 2>/dev/null
    ls /usr/lib/*/ /usr/lib/llvm-*/lib/ 2>/dev/null
}

have_library() {
    libraries | grep -q "$1"
}

# libLLVM-17.so.1 and later, or libLLVM.so.19.1: older ones lack instructions that the ray tracer's kernels use.
have_llvm() {
    libraries | sed -n 's/.*libLLVM\(-\|\.so\.\)\([0-9][0-9]*\).*/\2/p' | grep -qE '^(1[7-9]|[2-9][0-9])$'
}

have_vulkan_driver() {
    ls /usr/share/vulkan/icd.d/ /etc/vulkan/icd.d/ 2>/dev/null | grep -q json && have_library libvulkan.so.1
}

install() { # install PURPOSE PACKAGE...
    purpose=$1
    shift
    if ! command -v apt-get >/dev/null 2>&1; then
        say "$purpose is missing; install it with your package manager (on Debian: apt-get install $*)."
        exit 2
    fi
    if [ "$(id -u)" = 0 ]; then
        sudo=
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        sudo=sudo
    else
        say "$purpose is missing and needs an administrator: sudo apt-get install $*"
        exit 2
    fi
    say "$purpose is missing: installing $*"
    log=$(mktemp)
    if ! { $sudo apt-get update -qq &&
        DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends "$@"; } >"$log" 2>&1; then
        tail -n 5 "$log" >&2
        rm -f "$log"
        say "could not install $purpose; try: sudo apt-get install $*"
        exit 2
    fi
    rm -f "$log"
}

setup_python() {
    python=${PYTHON:-python3}
    if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
        say "Python 3.11 or later is needed, and $python is not; set PYTHON to one that is."
        exit 2
    fi
    missing=
    have_vulkan_driver || missing="$missing mesa-vulkan-drivers libvulkan1"
    have_llvm || missing="$missing libllvm19"
    have_library libatomic.so.1 || missing="$missing libatomic1"
    "$python" -c 'import ensurepip, venv' 2>/dev/null || missing="$missing python3-venv"
    [ -z "$missing" ] || install "a Vulkan driver, libLLVM 17 or later, libatomic or Python's venv" $missing
    [ -x .venv/bin/pip ] || "$python" -m venv --clear .venv
    say "installing Python packages into .venv"
    .venv/bin/pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
    .venv/bin/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
}

setup_web() {
    if ! command -v npm >/dev/null 2>&1 || ! node -e 'process.exit(process.versions.node.split(".")[0] < 18 ? 1 : 0)'; then
        install "Node.js 18 or later with npm" nodejs npm
    fi
    say "installing web packages into web/node_modules"
    # Not "npm ci": it refuses a lock without other platforms' optional binaries, which not every registry copy holds.
    (cd web && npm install --no-save --silent --no-progress)
}

setup_browser() {
    command -v chromium >/dev/null 2>&1 || install "Chromium (for the viewer's tests)" chromium
}

for room in "$@"; do
    case $room in
    python | web | browser) "setup_$room" ;;
    *) say "python, web or browser expected, not $room"; exit 2 ;;
    esac
done
