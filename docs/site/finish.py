#!/usr/bin/env python3
"""finish.py BOOK: completes a built site: its first page, its search without a network, and the files of the repository that pages link to.

Fails if a page is missing in the navigation, or the site has a link to nothing or needs a network.
"""
import html.parser
import os
import pathlib
import re
import shutil
import sys
import tomllib
import urllib.parse

book = pathlib.Path(sys.argv[1])
pages, site = book / "pages", book / "site"
problems = []


def listed(entry):
    if isinstance(entry, str):
        yield entry
    else:
        for value in entry.values() if isinstance(entry, dict) else entry:
            yield from listed(value)


navigation = list(listed(tomllib.loads(pathlib.Path("zensical.toml").read_text())["project"]["nav"]))
there = {path.relative_to(pages).as_posix() for path in pages.rglob("*.md")}
problems += [f"{page}: is not in the navigation of zensical.toml" for page in sorted(there - set(navigation))]
problems += [f"{page}: is in the navigation twice" for page in sorted({page for page in navigation if navigation.count(page) > 1})]


class Links(html.parser.HTMLParser):
    """What a page links to, and what it loads."""

    def __init__(self):
        super().__init__()
        self.links, self.loads = [], []

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "href" and tag == "a":
                self.links.append(value or "")
            elif name in ("src", "srcset", "href", "data", "poster"):
                self.loads.append(value or "")


# The generator would load this from a network.
SHIM = "https://unpkg.com/iframe-worker/shim"
worker = site / "assets/javascripts/worker.js"
shutil.copy("docs/site/worker.js", worker)
(site / "index.html").write_text('<!doctype html><title>Oneiro</title><meta http-equiv="refresh" content="0; url=docs/index.html">\n')

for path in sorted(site.rglob("*.html")):
    text = path.read_text().replace(SHIM, os.path.relpath(worker, path.parent))
    path.write_text(text)
    links = Links()
    links.feed(text)
    name = path.relative_to(site)
    problems += [f"{name}: loads {target}" for target in links.loads if re.match(r"(https?:)?//", target)]
    for target in links.links + links.loads:
        if re.match(r"[a-z]+:|//|#|$", target) or name.name == "404.html":
            continue
        file = path.parent / urllib.parse.unquote(re.split("[#?]", target)[0])
        if file.exists():
            continue
        source = pathlib.Path(os.path.relpath(file, site))
        if source.is_dir() and ".." not in source.parts:
            shutil.copytree(source, file)
        elif source.exists() and ".." not in source.parts:
            file.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, file)
        else:
            problems.append(f"{name}: there is no {target}")
for path in [*site.rglob("*.css"), *site.rglob("*.js")]:
    problems += [f"{path.relative_to(site)}: loads {url}" for url in re.findall(r"(?:url\(|@import |importScripts\()[\"']?(https?://[^\"')]*)", path.read_text())]
if not list(site.rglob("search.js*")):
    problems.append("there is no search index")
if problems:
    sys.exit("\n".join(problems))
