#!/bin/sh
# Prints the first Python that is new enough for the project. $PYTHON, when set, is the only candidate.
set -eu

for candidate in ${PYTHON:-python3.13 python3.12 python3.11 python3}; do
    # A name on the PATH proves little: version managers leave shims that only print an error.
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; then
        echo "$candidate"
        exit 0
    fi
done

echo "aos-gcs needs Python 3.11 or newer, and ${PYTHON:-python3} is missing or older: install one," \
    "or name it with PYTHON=/path/to/python3." >&2
exit 1
