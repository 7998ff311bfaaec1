#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# All checks, those too that .ci/run leaves out where nothing has changed: each night, and before a release. If all have
# passed and the tree is clean, the last line is what a commit of tests/passed.txt alone records. Hours more take
# tests/judges.sh, tests/pairs.sh, tests/mutate/run.sh and the whole product of interpretations.
set -u
cd "$(dirname "$0")/.." || exit 1

SERVOBUS_EVERYTHING=1 sh .ci/run || exit 1
if [ -n "$(git status --porcelain)" ]; then
    echo "everything.sh: all passed; nothing to record, since the tree has changes that are not committed"
else
    echo "everything.sh: all passed; to record it:"
    echo "echo '$(git rev-parse HEAD) $(date +%F)' >tests/passed.txt && git commit -m 'Record that everything passed' tests/passed.txt"
fi
