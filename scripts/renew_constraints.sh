#!/bin/sh
# Writes constraints.txt: what pip chooses for the package with all its extras in a clean environment.
set -eu

environment=.make/constraints
mkdir -p .make
sh scripts/make_venv.sh "$environment"
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check \
    --editable ".[sim,lab,mavsdk,video,geo,report,dev]"
{
    echo "# Exact versions of everything that the package and its extras need."
    echo "# Made by \`make constraints\`; do not edit."
    "$environment/bin/python" -m pip freeze --exclude-editable
} >constraints.txt.part
mv constraints.txt.part constraints.txt
rm -rf "$environment"
