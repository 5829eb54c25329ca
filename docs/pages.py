#!/usr/bin/env python3
"""Preprocessor of mdBook: turns pages for a code host into chapters.

Code hosts set formulas between `$` and in blocks of the language `math`; mdBook has MathJax, whose delimiters are `\\(` and
`\\[`, and would take what is between them for Markdown. Links to files outside of docs/ lead from the book to the
repository (`root` in book.toml). Code is left alone. mdBook sends [context, book] as JSON and reads the book back.
"""
import json
import re
import sys

BLOCK = re.compile(r"^```math\n(.*?)^```$", re.M | re.S)
CODE = re.compile(r"(^```.*?^```$|(?:^ {4}[^\n]*\n)+|`[^`\n]+`)", re.M | re.S)
INLINE = re.compile(r"\$(\S|\S[^$]*?\S)\$")
OUTSIDE = re.compile(r"(?<=\]\()\.\./([^)\s]+)")
SPECIAL = re.compile(r"([!-/:-@\[-`{-~])")


def formula(tex, left, right):
    """Markdown that comes out as TeX between MathJax's delimiters."""
    return SPECIAL.sub(r"\\\1", left + " ".join(tex.split()) + right)


def chapter(text, root):
    text = BLOCK.sub(lambda m: formula(m[1], r"\[", r"\]"), text)
    parts = CODE.split(text)
    # split() puts what CODE matched at odd places.
    for i in range(0, len(parts), 2):
        parts[i] = INLINE.sub(lambda m: formula(m[1], r"\(", r"\)"), parts[i])
        # mdBook makes .html of .md, but what is out there is no chapter.
        parts[i] = OUTSIDE.sub(lambda m: f"{root}/{m[1]}".replace(".md", "%2Emd"), parts[i])
    return "".join(parts)


def walk(items, root):
    for item in items:
        if isinstance(item, dict) and "Chapter" in item:
            item["Chapter"]["content"] = chapter(item["Chapter"]["content"], root)
            walk(item["Chapter"]["sub_items"], root)


def main():
    if sys.argv[1:2] == ["supports"]:
        sys.exit(sys.argv[2] != "html")
    context, book = json.load(sys.stdin)
    root = context["config"]["preprocessor"]["pages"]["root"]
    walk(book.get("items", book.get("sections", [])), root)
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
