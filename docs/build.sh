#!/usr/bin/env bash
# build.sh: makes the book, a site of docs/ that can be searched without a network: target/book/site. Strict: a warning is an error; so
# is a page that zensical.toml does not list, a link to nothing, and whatever the site would fetch from elsewhere.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/install.sh

version=0.0.73
say() { printf '\n== %s\n' "$*"; }
fail() {
    echo "the book: $*" >&2
    exit 1
}

# The site must be below the folder of zensical.toml, so not in CARGO_TARGET_DIR.
book=target/book
rm -rf "$book"
mkdir -p "$book/pages"
# Pages keep their places, and with them their links. What they link to outside of docs/ comes along.
cp -r docs CONTRIBUTING.md CHANGELOG.md "$book/pages/"
cp --parents studies/*.md studies/*/README.md "$book/pages/"
rm -r "$book/pages/docs/site"
find "$book/pages" -name '*.new' -delete
# The words after a block's language are for tests.
find "$book/pages" -name '*.md' -exec sed -i 's/^\( *```[a-z]\+\) .*/\1/' {} +

python_folder=python-book python_with zensical "zensical==$version" || fail "$problem"
zensical=${python%/*}/zensical
strip() { sed 's/\x1b\[[0-9;]*m//g'; }
"$zensical" build --clean --strict 2>&1 | strip || fail "warnings are above"
rm -rf .cache
"$python" docs/site/finish.py "$book"
echo "$book/site/index.html"
