#!/usr/bin/env python3
"""notices.py [--check]: writes packaging/third-party.txt, the licences of all packages by others that the program and the wheel contain. With
--check, fails if the file is not current. Needs cargo, and the packages' sources, which any build has fetched."""

import collections
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FILE = ROOT / "packaging/third-party.txt"
# With all that any of them contains, on all processors and systems.
FEATURES = ["--features", "oneiro-host/default,oneiro-host/parquet,oneiro-python/gpu"]
PROGRAMS = ("oneiro-host", "oneiro-python")
# May be combined with a program under MIT or Apache 2.0, and ask for no more than a notice, and MPL for the address of the unchanged source.
# A package that offers one of these licences and another one is taken under one of these.
ALLOWED = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "ISC", "MIT", "MIT-0",
    "MPL-2.0", "Unicode-3.0", "Unlicense", "Zlib",
}  # fmt: skip


def contained(metadata: dict) -> list[dict]:
    """Packages by others that the programs contain: all that they depend on, except by build scripts, macros and tests."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    packages = {package["id"]: package for package in metadata["packages"]}

    def is_macro(identity: str) -> bool:
        return any("proc-macro" in target["kind"] for target in packages[identity]["targets"])

    found: set[str] = set()
    todo = [identity for identity in nodes if packages[identity]["name"] in PROGRAMS]
    while todo:
        identity = todo.pop()
        if identity in found or is_macro(identity):
            continue
        found.add(identity)
        for dependency in nodes[identity]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                todo.append(dependency["pkg"])
    others = [packages[identity] for identity in found if packages[identity]["source"]]
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def is_allowed(expression: str) -> bool:
    """Whether a licence expression can be met by allowed licences."""
    words = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))
    text, licence = "", ""
    for word in [*words, ")"]:
        if word in ("(", ")", "AND", "OR"):
            text += f" {licence.strip() in ALLOWED}" if licence else ""
            text += f" {word.lower()}"
            licence = ""
        else:
            licence += f" {word}"
    return bool(eval(text.removesuffix(" )")))


def texts(package: dict) -> list[str]:
    """The texts of a package's licences and notices."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [path for path in sorted(folder.iterdir()) if path.is_file()]
    named = [path for path in files if re.match(r"(licen[cs]e|copying|notice|unlicense|copyright)", path.name, re.I)]
    # Where there is a choice, MIT: its text has the names of those who wrote the package.
    mit = [path for path in named if "MIT" in path.name.upper()]
    if mit and "AND" not in package["license"]:
        named = mit
    read = [path.read_text("utf-8", "replace").replace("\r\n", "\n").strip() for path in named]
    return [re.sub(r"[ \t]+\n", "\n", text) for text in read if text]


def notices() -> str:
    arguments = ["cargo", "metadata", "--format-version", "1", "--offline", *FEATURES]
    metadata = json.loads(subprocess.run(arguments, cwd=ROOT, check=True, capture_output=True).stdout)
    packages = contained(metadata)
    refused = [f"{p['name']} {p['version']}: {p['license']}" for p in packages if not is_allowed(p["license"] or "")]
    if refused:
        sys.exit("licences that are not in the list of packaging/notices.py: " + "; ".join(refused))
    # By their words, however their lines are broken.
    users = collections.defaultdict(list)
    written = {}
    without = []
    lines = ["Oneiro contains these packages by others, under these licences.", ""]
    for package in packages:
        name = f"{package['name']} {package['version']}"
        lines.append(f"{name}: {package['license']}, {package['repository'] or 'no address given'}")
        found = texts(package)
        for text in found:
            words = " ".join(text.split())
            users[words].append(name)
            written.setdefault(words, text)
        if not found:
            without.append(name)
    if without:
        lines += ["", "Packages that contain no text of a licence: " + ", ".join(without) + "."]
    for words, names in users.items():
        lines += ["", "-" * 100, ", ".join(names), "-" * 100, "", written[words]]
    return "\n".join(lines) + "\n"


def main() -> None:
    text = notices()
    if sys.argv[1:] == ["--check"]:
        if not FILE.exists() or FILE.read_text() != text:
            sys.exit("packaging/third-party.txt is not current; write it: packaging/notices.py")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        FILE.write_text(text)


main()
