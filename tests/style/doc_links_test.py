#!/usr/bin/env python3
"""Plants pages in a small tree and checks that doc_links.py reports what is dead and nothing else."""
import pathlib
import tempfile
import unittest

from doc_links import problems

TREE = {
    "README.md": "# House\n",
    "docs/drawing.md": "# Drawing\n\n## What no camera saw\n\n```\n# no heading\n```\n\n"
                       "## `fast`, and why\n\n## Twice\n\n## Twice\n",
    "docs/picture.svg": "<svg/>\n",
    "docs/experiments/README.md": "# Experiments\n",
    "src/core/image.h": "#pragma once\n",
}


class DocLinks(unittest.TestCase):
    def problems_with(self, page, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            for name, content in {**TREE, page: text}.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(content, encoding="utf-8")
            return problems(root)

    def test_accepts_what_is_there(self):
        for page, text in [
            ("README.md", "[drawing](docs/drawing.md), [why](docs/drawing.md#what-no-camera-saw)"),
            ("README.md", '<img src="docs/picture.svg" width="9">'),
            ("README.md", "see `src/core/image.h`, src/core/ and src/core."),
            ("README.md", "[elsewhere](https://example.org/src/nothing.h) and [mail](mailto:a@b.c)"),
            ("README.md", "`[not](a/link.md)` in code; build/release/src/nothing.h is no path of the tree"),
            ("docs/a.md", "# A\n[top](#a), ![picture](picture.svg), [up](../README.md), [folder](experiments)"),
            ("docs/a.md", "[fast](drawing.md#fast-and-why), [second](drawing.md#twice-1)"),
            ("docs/experiments/b.md", "measured when src/old/name.h was there; [back](../drawing.md)"),
        ]:
            self.assertEqual(self.problems_with(page, text), [], f"{page}: {text}")

    def test_reports_what_is_not(self):
        for page, text, said in [
            ("README.md", "[gone](docs/gone.md)", "docs/gone.md"),
            ("README.md", '<img src="docs/gone.webp">', "docs/gone.webp"),
            ("README.md", "[gone](docs/drawing.md#gone)", "no such heading"),
            ("README.md", "[code](docs/drawing.md#no-heading)", "no such heading"),
            ("README.md", "[out](../elsewhere)", "elsewhere"),
            ("docs/a.md", "in `src/core/gone.h`", "src/core/gone.h"),
            ("docs/a.md", "below src/gone/ too", "src/gone"),
            ("docs/a.md", "[wrong folder](docs/drawing.md)", "docs/drawing.md"),
            ("docs/experiments/b.md", "[gone](gone.md)", "gone.md"),
        ]:
            found = self.problems_with(page, text)
            self.assertEqual(len(found), 1, f"{page}: {text}: {found}")
            self.assertTrue(found[0].startswith(f"{page}:1: "), found[0])
            self.assertIn(said, found[0])


if __name__ == "__main__":
    unittest.main()
