#!/bin/sh
# Makes the virtual environment named by $1.
set -eu

python=$(sh scripts/find_python.sh)
if ! "$python" -c 'import ensurepip, venv' >/dev/null 2>&1; then
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    echo "$python cannot make virtual environments: install its venv module" \
        "(Debian and Ubuntu: sudo apt-get install python$version-venv)." >&2
    exit 1
fi
"$python" -m venv --clear "$1"
