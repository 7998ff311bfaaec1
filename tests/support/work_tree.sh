# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Read by `. tests/support/work_tree.sh` in the project's root: a repository $tree of what the work tree has, so that
# changes that are not yet committed are checked, and so that this runs in a tree without git too. It wants `work`, a
# folder.
tree=$work/tree
commit() { # MESSAGE
    git -C "$tree" add -A &&
        git -C "$tree" -c user.name=test -c user.email=test@example.org -c commit.gpgsign=false \
            -c core.hooksPath=/dev/null commit -q -m "$1"
}
mkdir "$tree"
if [ "$(git rev-parse --show-toplevel 2>/dev/null)" = "$(pwd)" ]; then
    git ls-files -z --cached --others --exclude-standard
else
    find . -type f ! -path './build*' ! -path './.git/*' -print0
fi | xargs -0 sh -c 'for file; do [ ! -e "$file" ] || echo "$file"; done' list | tar cf - -T - | tar xf - -C "$tree"
git -C "$tree" init -q && commit "What the work tree has" || exit 1
