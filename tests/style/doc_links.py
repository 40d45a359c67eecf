#!/usr/bin/env python3
"""Checks that what README.md and docs/ point to is there: relative links, their anchors, and paths of the source tree.

usage: doc_links.py ROOT    Prints one line per dead link or path; exits 1 if there are any.

Paths such as `src/core/image.h` are not looked for in docs/experiments: what was measured there may name files of its time.
"""
import pathlib
import re
import sys

EXPERIMENTS = "docs/experiments/"
# [text](target), ![text](target) and <img src="target">; not in code.
LINK = re.compile(r'\]\(<?([^)\s>]+)>?(?:\s+"[^"]*")?\)|\bsrc="([^"]+)"')
PATH = re.compile(r"(?<![\w./-])(?:src|include|formats|tests|bench|scripts|samples|docs|cmake)/[\w./-]*[\w/]")
HEADING = re.compile(r"^#{1,6}\s+(.*?)\s*#*\s*$")
FENCE = re.compile(r"^\s*(```|~~~)")
CODE = re.compile(r"`[^`]*`")


def pages(root):
    """README.md files of the root and of samples/, and everything below docs/, as names below the root."""
    found = [p for p in (root / "README.md", root / "samples/README.md") if p.is_file()]
    found += sorted((root / "docs").rglob("*.md"))
    return [p.relative_to(root).as_posix() for p in found]


def anchor_of(heading):
    """What GitHub makes of a heading: lower case, no punctuation, hyphens for spaces."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchors(text):
    found, fenced = set(), False
    for line in text.splitlines():
        if FENCE.match(line):
            fenced = not fenced
        match = HEADING.match(line)
        if match and not fenced:
            name, number = anchor_of(match.group(1)), 0
            while (name if number == 0 else f"{name}-{number}") in found:
                number += 1
            found.add(name if number == 0 else f"{name}-{number}")
    return found


def dead_link(root, page, target):
    """Why a link leads nowhere, or None."""
    if re.match(r"[a-z][a-z0-9+.-]*:", target):  # another site
        return None
    name, _, anchor = target.partition("#")
    file = (root / page).parent / name if name else root / page
    if not file.exists():
        return "there is no such file"
    if not file.resolve().is_relative_to(root):
        return "it leads out of the repository"
    if anchor and (file.suffix != ".md" or anchor not in anchors(file.read_text(encoding="utf-8"))):
        return "the page has no such heading"
    return None


def problems(root):
    found = []
    for page in pages(root):
        for number, line in enumerate((root / page).read_text(encoding="utf-8").splitlines(), 1):
            where = f"{page}:{number}"
            for match in LINK.finditer(CODE.sub("", line)):
                target = match.group(1) or match.group(2)
                if (why := dead_link(root, page, target)) is not None:
                    found.append(f"{where}: link to {target}: {why}")
            if page.startswith(EXPERIMENTS):
                continue
            for path in PATH.findall(LINK.sub("", line)):
                if not (root / path).exists():
                    found.append(f"{where}: {path} does not exist")
    return found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = problems(pathlib.Path(sys.argv[1]).resolve())
    for line in found:
        print(line)
    if found:
        sys.exit(f"{len(found)} dead links and paths in the documentation")


if __name__ == "__main__":
    main()
